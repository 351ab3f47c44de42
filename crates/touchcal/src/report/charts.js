"use strict";
// The charts, by Observable Plot: SVG whose colours are the page's, so that light, dark and paper need no second drawing.

const BEFORE = "var(--before)", AFTER = "var(--after)", BAD = "var(--bad)", SOFT = "var(--soft)";
/** Distances (m) below this are drawn at it: a logarithm has no zero. */
const LEAST = 1e-7;
const toMm = (metres) => 1e3 * Math.max(LEAST, metres);
/** A name as long as a label may be. */
const short = (name) => (name.length > 20 ? `${name.slice(0, 19)}…` : name);
/** A number with few digits; of tiny and of huge ones the power of ten. */
function power(value) {
  const exponent = Math.floor(Math.log10(Math.abs(value)) + 1e-9);
  if (value === 0 || Math.abs(exponent) <= 3) return significant(value, 2);
  const times = Math.round(Math.abs(value) / 10 ** exponent);
  return `${value < 0 ? "−" : ""}${times === 1 ? "" : `${times}·`}10${[...`${exponent}`].map((digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)]).join("")}`;
}
/** A logarithmic axis over these values: ticks at powers of ten, of a short one at their double and fivefold too. */
function log(label, values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const powers = [], every = Math.max(1, Math.ceil(Math.log10(high / low) / 7));
  for (let k = Math.floor(Math.log10(low)); k <= Math.ceil(Math.log10(high)); k += every) powers.push(10 ** k);
  const ticks = high / low > 200 ? powers : powers.flatMap((tick) => [tick, 2 * tick, 5 * tick]);
  return { type: "log", label, grid: true, ticks: ticks.filter((tick) => tick >= 0.999 * low && tick <= 1.001 * high), tickFormat: power, tickSize: 4 };
}

const charts = {
  histogram(width) {
    const total = data.contacts.used + data.contacts.rejected;
    const bars = data.contacts.histogram.map(({ from, to, before, after }) => ({ from: 1e3 * from, to: 1e3 * to, before: (100 * before) / total, after: (100 * after) / total }));
    if (!bars.length) return null;
    const rects = (y, fill) => plot.rectY(bars, { x1: "from", x2: "to", y, fill, fillOpacity: 0.75, insetLeft: 0.5, insetRight: 0.5,
      title: (bar) => `${significant(bar.from, 2)} to ${significant(bar.to, 2)} mm\n${significant(bar[y], 2)} % of the contacts ${y}` });
    return { width, height: 260, marginLeft: 40, x: log("distance from contact (mm) →", bars.flatMap(({ from, to }) => [from, to])), y: { label: "↑ share of the contacts (%)", grid: true, ticks: 5, nice: true },
      marks: [rects("before", BEFORE), rects("after", AFTER), plot.ruleY([0], { stroke: SOFT })] };
  },

  fixtures(width) {
    const shown = [...data.fixtures].sort((a, b) => b.change.after.rms - a.change.after.rms).slice(0, 40);
    const rows = data.fixtures.filter((fixture) => shown.includes(fixture) && fixture.contacts)
      .map(({ name, contacts, change: { before, after } }) => ({ name, contacts, before: toMm(before.rms), after: toMm(after.rms), most: toMm(after.max), mostBefore: toMm(before.max) }));
    if (!rows.length) return null;
    const tip = (row) => `${row.name}, ${row.contacts} contacts\nbefore: rms ${significant(row.before)} mm, max ${significant(row.mostBefore)} mm\nafter: rms ${significant(row.after)} mm, max ${significant(row.most)} mm`;
    const label = 16 + 7 * Math.max(...rows.map((row) => short(row.name).length));
    const pair = (key, most, stroke) => [
      plot.link(rows, { x1: key, x2: most, y1: "name", y2: "name", stroke, strokeOpacity: 0.5 }),
      plot.dot(rows, { x: key, y: "name", fill: stroke, r: 4, title: tip }),
      plot.dot(rows, { x: most, y: "name", stroke, symbol: "times", r: 3, title: tip }),
    ];
    return { width, height: 64 + 22 * Math.max(rows.length, 3), marginTop: 8, marginLeft: label, x: log("distance from contact (mm): ● rms, × largest →", rows.flatMap(({ before, after, most, mostBefore }) => [before, after, most, mostBefore])),
      y: { label: null, domain: rows.map((row) => row.name), tickSize: 0, tickFormat: short }, marks: [plot.ruleY(rows, { y: "name", stroke: "var(--faint)" }), ...pair("before", "mostBefore", BEFORE), ...pair("after", "most", AFTER)] };
  },

  course(width) {
    const { drawn, sections } = data.contacts;
    const points = drawn.index.map((index, k) => ({ index: index + 1, fixture: drawn.fixture[k], file: drawn.file[k], line: drawn.line[k], before: toMm(drawn.before[k]), after: toMm(drawn.after[k]), rejected: drawn.rejected[k] }));
    if (!points.length) return null;
    const tip = (point) => `contact ${point.index}: ${place(point)}\n${data.fixtures[point.fixture].name}\nbefore ${significant(point.before)} mm, after ${significant(point.after)} mm${point.rejected ? ", rejected" : ""}`;
    const [kept, rejected] = [0, 1].map((is) => points.filter((point) => point.rejected === is));
    const dots = (y, fill) => plot.dot(kept, { x: "index", y, fill, r: 1.6, fillOpacity: points.length > 500 ? 0.45 : 0.8 });
    const changes = points.filter((point, k) => k > 0 && point.fixture !== points[k - 1].fixture);
    const steps = (y) => sections.flatMap((part) => [{ x: part.from + 1, y: toMm(part[y]) }, { x: part.to, y: toMm(part[y]) }]);
    const line = (y, stroke) => (sections.length > 1 ? [points.length > 500 ? plot.line(steps(y), { x: "x", y: "y", stroke: "var(--paper)", strokeWidth: 3.5 }) : null, plot.line(steps(y), { x: "x", y: "y", stroke, strokeWidth: 1.8 })] : []);
    return { width, height: 320, marginLeft: 48, x: { label: "contact, in log order →" }, y: log("↑ distance from contact (mm)", points.flatMap(({ before, after }) => [before, after])),
      marks: [changes.length <= 60 ? plot.ruleX(changes, { x: "index", stroke: "var(--faint)" }) : null, dots("before", BEFORE), dots("after", AFTER),
        plot.dot(rejected, { x: "index", y: "after", stroke: BAD, symbol: "times", r: rejected.length > 300 ? 2 : 3.5, strokeWidth: rejected.length > 300 ? 0.8 : 1.5 }),
        ...line("before", BEFORE), ...line("after", AFTER),
        plot.tip(points, plot.pointer({ x: "index", y: "after", title: tip, maxRadius: 30 }))] };
  },

  singular(width) {
    const { singular_values, rank, unknown } = data.parameters;
    const points = singular_values.map((value, k) => ({ k: k + 1, value: Math.max(value, 1e-4), of: value }));
    if (unknown || !points.length || !(singular_values[0] > 0)) return null;
    return { width, height: 260, marginLeft: 56, x: { label: "direction, in descending order →", tickFormat: "d", ticks: Math.min(points.length, 8) }, y: log("↑ singular value", [1, ...points.map(({ value }) => value)]),
      marks: [plot.ruleY([1], { stroke: BAD, strokeDasharray: "4 3" }),
        plot.text([[1, 1]], { text: ["1: as informative as the prior"], textAnchor: "start", dx: 4, dy: -8, fill: SOFT }),
        plot.dot(points, { x: "k", y: "value", r: 3.5, stroke: (point) => (point.k <= rank ? AFTER : SOFT), fill: (point) => (point.k <= rank ? AFTER : "var(--paper)"), title: (point) => `direction ${point.k}: ${significant(point.of)}` })] };
  },

  correlation(width) {
    const { correlated, correlation, each } = data.parameters;
    if (correlated.length < 2) return null;
    const size = correlated.length, names = correlated.map((k) => each[k].name.replace(/^joint_(offset|origin|compliance)\./, "").replace(/^(fixture|segment_strain)\./, ""));
    const cells = correlation.flatMap((row, i) => row.map((value, j) => ({ i, j, value }))).filter((cell) => cell.value != null);
    // Many are named in groups: of one joint or fixture.
    const owner = (k) => (size > 30 && names[k].includes(".") ? names[k].slice(0, names[k].lastIndexOf(".")) : names[k]);
    const domain = correlated.map((_, k) => k);
    const groups = domain.filter((k) => k === 0 || owner(k) !== owner(k - 1)).map((from) => ({ from, size: domain.filter((k) => k >= from).findIndex((k) => owner(k) !== owner(from)) }));
    groups.forEach((group) => (group.size = group.size < 0 ? size - group.from : group.size));
    const label = 14 + 6.4 * Math.max(...groups.map(({ from }) => short(owner(from)).length));
    const cell = (width - label - 8) / size, font = Math.min(11, Math.max(7, cell * Math.min(...groups.map((group) => group.size))));
    return { width, height: cell * size + 20, marginLeft: label, marginRight: 8, marginTop: 4, marginBottom: 16, x: { axis: null, domain, padding: 0.06 }, y: { axis: null, domain, padding: 0.06 },
      marks: [
        plot.cell(cells, { x: "j", y: "i", fill: (d) => (d.value < 0 ? "var(--minus)" : "var(--plus)"), fillOpacity: (d) => Math.abs(d.value),
          title: (d) => `${each[correlated[d.i]].description}\n${each[correlated[d.j]].description}\ncorrelation ${significant(d.value, 2)}` }),
        plot.cell(domain, { x: (k) => k, y: (k) => k, fill: "var(--faint)" }),
        plot.text(groups, { x: () => 0, y: ({ from, size }) => from + Math.floor((size - 1) / 2), text: ({ from }) => short(owner(from)), textAnchor: "end", dx: -cell / 2 - 4, fontSize: font, fill: SOFT }),
      ] };
  },

  "uncertainty-chart"(width) {
    if (!data.uncertainty) return null;
    const { fixtures, workspace, distances } = data.uncertainty;
    const rows = [["position in base, at fixtures", fixtures.map(([f, pose]) => [pose.position, data.fixtures[f].name])], ["position in base, workspace", workspace.map((pose) => [pose.position])],
      ["between two positions", distances.map((sigma) => [sigma])]];
    const points = rows.flatMap(([row, each]) => each.map(([sigma, name]) => ({ row, sigma: 1e3 * sigma, name }))).filter((point) => point.sigma > 0);
    if (!points.length) return null;
    const middles = rows.map(([row, each]) => ({ row, sigma: 1e3 * quantile(each.map(([sigma]) => sigma), 0.5) })).filter((point) => point.sigma > 0);
    // Where on the axis, so that the words beside it stay in the chart.
    const [low, high] = [Math.min, Math.max].map((end) => Math.log(end(...points.map(({ sigma }) => sigma))));
    const share = (sigma) => (high > low ? (Math.log(sigma) - low) / (high - low) : 0);
    return { width, height: 170, marginLeft: width < 560 ? 100 : 190, x: log("standard deviation (mm) →", points.map(({ sigma }) => sigma)), y: { label: null, domain: rows.map(([row]) => row), tickSize: 0, tickFormat: (row) => (width < 560 ? row.replace(/(, | (?=positions))/, (gap) => `${gap.trim()}\n`).replace("position in base,\n", "in base,\n") : row) },
      marks: [plot.dot(points, { x: "sigma", y: "row", fill: AFTER, fillOpacity: (point) => (point.name ? 1 : 0.15), r: 4, title: (point) => `${point.name ? `${point.name}: ` : ""}${significant(point.sigma)} mm` }),
        ...[["start", 0, 0.3], ["middle", 0.3, 0.7], ["end", 0.7, 2]].map(([textAnchor, from, to]) => plot.text(middles.filter(({ sigma }) => share(sigma) >= from && share(sigma) < to), { x: "sigma", y: "row", text: ({ sigma }) => `median ${significant(sigma, 2)} mm`, textAnchor, dy: -15, fill: "var(--ink)" }))] };
  },

  joints(width) {
    const { q, calibrated } = data.scene, { drawn, every } = data.contacts;
    const shown = residualRows()[rowOf()];
    if (!shown) return null;
    const which = drawn.index.flatMap((index, k) => (index % every === 0 && !drawn.rejected[k] && shown.of.has(data.fixtures[drawn.fixture[k]].residual) ? [k] : []));
    const toMm = UNITS.m[0], residual = which.map((k) => toMm * drawn.residual[k][shown.row]);
    if (!which.length) return null;
    const [low, high] = [0.005, 0.995].map((share) => quantile(residual, share));
    const moving = calibrated.joints.filter(({ kind }) => kind !== "fixed").map(({ name, kind }, j) => {
      const [factor, symbol] = kind === "slides" ? UNITS.m : UNITS.rad;
      const points = which.map((k, i) => ({ k, x: factor * q[k][j], y: residual[i] }));
      return { label: `${short(name)} (${symbol}) →`, points, line: means(points) };
    });
    const reach = 1.08 * Math.max(1e-6, ...[low, high, ...moving.flatMap(({ line }) => line.map(({ y }) => y))].map(Math.abs));
    const is_within = (y) => Math.abs(y) <= reach, beyond = residual.filter((y) => !is_within(y)).length;
    jointsNote(which.length, beyond);
    const across = Math.min(4, Math.max(1, Math.floor(width / 250))), thin = Math.ceil(which.length / 300);
    return moving.map(({ label, points, line }, j) => ({ width: Math.floor((width - 16 * (across - 1)) / across), height: 170, marginLeft: 50, marginRight: 10, marginTop: 24, x: { label, ticks: 4, tickSize: 4 }, y: { label: j % across ? null : "↑ residual (mm)", domain: [-reach, reach], grid: true, ticks: 4, tickSize: 4, tickFormat: (value) => significant(value, 2) },
      marks: [plot.ruleY([0], { stroke: SOFT }), plot.dot(points.filter(({ y }, i) => i % thin === 0 && is_within(y)), { x: "x", y: "y", fill: AFTER, fillOpacity: 0.4, r: 1.5, title: ({ k }) => place({ file: drawn.file[k], line: drawn.line[k] }) }),
        plot.line(line, { x: "x", y: "y", stroke: "var(--ink)", strokeWidth: 1.8 })] }));
  },

  map(width) {
    if (!data.uncertainty) return null;
    const [toMm] = UNITS.m, { workspace } = data.uncertainty, limits = quarters();
    const level = (sigma) => limits.filter((limit) => sigma > limit).length;
    const points = workspace.map(({ radius, height, position }) => ({ x: toMm * radius, y: toMm * height, level: level(position), sigma: position }));
    const parts = data.scene.fixtures.flatMap((part, f) => (part ? [{ part, name: data.fixtures[f].name }] : [])).map(({ part: { base_from_fixture: [x, y, z] }, name }) => ({ x: toMm * Math.hypot(x, y), y: toMm * z, name }));
    const [xs, ys] = ["x", "y"].map((axis) => [...points, ...parts].map((point) => point[axis]));
    const span = (values) => Math.max(...values) - Math.min(...values) || 1;
    const wide = Math.min(width, 640), left = 56, tall = Math.min(560, ((wide - left - 20) * span(ys)) / span([0, ...xs]) + 72);
    return { width: wide, height: Math.round(tall), marginLeft: left, marginTop: 30, x: { label: "distance from the axis (mm) →", domain: [0, Math.max(...xs)], nice: true, grid: true, ticks: 5 }, y: { label: "↑ height (mm)", grid: true, ticks: 6, nice: true },
      marks: [plot.dot(points, { x: "x", y: "y", fill: ({ level }) => `var(--ramp-${level})`, r: ({ level }) => 2.5 + 0.9 * level, title: ({ sigma }) => `standard deviation ${mm(sigma)}` }),
        plot.dot(parts, { x: "x", y: "y", symbol: "plus", r: 6, stroke: BAD, strokeWidth: 2, title: "name" })] };
  },

  "convergence-chart"(width) {
    const shown = data.pieces.map(({ stage, steps }, k) => ({ stage, k, steps: steps.filter(([, cost]) => cost != null).map(([step, cost]) => ({ step, cost })) })).filter(({ steps }) => steps.length);
    if (!shown.length) return null;
    const across = Math.min(4, Math.max(2, Math.floor(width / 170)));
    const number = (value) => (Math.abs(value) >= 1e5 ? power(value) : significant(value, 4));
    return shown.map(({ stage, k, steps }) => {
      const costs = steps.map(({ cost }) => cost), least = Math.min(...costs), most = Math.max(...costs);
      const is_wide = least > 0 && most > 30 * least, stroke = stage === "coarse" ? BEFORE : AFTER;
      const y = { type: is_wide ? "log" : "linear", label: `↑ cost, ${k + 1}: ${stage}`, grid: true, ticks: [...new Set([least, most])], tickSize: 4, tickFormat: number };
      const every = Math.ceil(steps.length / 4), ticks = steps.filter((_, i) => i % every === 0).map(({ step }) => step);
      return { width: Math.floor((width - 16 * (across - 1)) / across), height: 150, marginLeft: 58, marginRight: 12, marginTop: 26, x: { label: "step →", ticks, tickFormat: "d", tickSize: 4 }, y,
        marks: [plot.line(steps, { x: "step", y: "cost", stroke, strokeWidth: 1.5 }), plot.dot(steps, { x: "step", y: "cost", fill: stroke, r: 2.5, title: ({ step, cost }) => `step ${step}: ${significant(cost, 4)}` })] };
    });
  },
};

/** Rows of residuals that can be drawn: what they are called, and of which kinds of contact they are. */
function residualRows() {
  const kinds = new Set(data.fixtures.filter(({ contacts }) => contacts).map(({ residual }) => residual));
  const of = (...names) => new Set(names.filter((name) => kinds.has(name)));
  const vectors = of("offset", "projection"), lengths = of("gap", "distance");
  const each = [...["x", "y", "z"].map((axis, row) => ({ name: `${axis}, in the fixture’s frame`, row, of: vectors })), { name: "signed gap", row: 0, of: lengths }];
  return each.filter((one) => one.of.size);
}
/** Which of them is chosen. */
const rowOf = () => Number(document.querySelector("#rows-control select")?.value ?? 0);

/** Which contacts the charts against joint positions show, and how many of them are `beyond` their range. */
function jointsNote(total, beyond) {
  const rows = residualRows();
  byId("joints-note").textContent = (rows.length > 1 ? "" : `Residual: ${rows[0].name}. `)
    + (data.fixtures.some(({ residual }) => residual === "gap") ? "A gap is the least of several noisy ones, so it is negative on average. " : "")
    + "Contacts after the calibration, evenly spread over the log, without rejected ones; lines are means over stretches"
    + (beyond ? `, with the ${beyond} of ${count(total, "contact")} that ${beyond === 1 ? "is" : "are"} beyond the range of the axis. ` : ". ")
    + "A mean that bends with a joint's position is an error that the model lacks.";
}

/** Means of the points over stretches of x, with as many points in each. */
function means(points) {
  const sorted = [...points].sort((a, b) => a.x - b.x), size = Math.max(5, Math.ceil(sorted.length / 16));
  const mean = (some, axis) => some.reduce((sum, point) => sum + point[axis], 0) / some.length;
  return Array.from({ length: Math.floor(sorted.length / size) }, (_, k) => sorted.slice(k * size, (k + 1) * size)).map((some) => ({ x: mean(some, "x"), y: mean(some, "y") }));
}

/** Quartiles of the tool's standard deviation over the workspace (m). */
const quarters = () => [0.25, 0.5, 0.75].map((share) => quantile(data.uncertainty.workspace.map(({ position }) => position), share));

/** The choice among several rows, and what the colours of the map mean. */
function controls() {
  const rows = residualRows();
  if (rows.length > 1) {
    const choice = el("select", {}, ...rows.map(({ name }, k) => el("option", { value: k }, name)));
    choice.addEventListener("change", () => {
      delete byId("joints").dataset.width;
      draw();
    });
    byId("rows-control").append(el("label", {}, "residual", choice));
  }
  if (!data.uncertainty) return;
  const [low, middle, high] = quarters().map((limit) => mm(limit, 2));
  const words = [`up to ${low}`, `to ${middle}`, `to ${high}`, "more"];
  byId("map-legend").append("standard deviation", ...words.map((text, level) => el("span", { class: `level level-${level}` }, text)), el("span", { class: "part" }, "fixtures"));
}

/** A chart as a picture with the caption of its figure as its name: to those who hear the page its marks are not named one by one. */
function picture(svg, figure) {
  svg.querySelectorAll("[aria-label]").forEach((group) => group.removeAttribute("aria-label"));
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", (figure.querySelector("figcaption") ?? figure.closest("section").querySelector("h2")).textContent);
  return svg;
}

/** Draws each chart as wide as its place. */
function draw() {
  for (const [id, chart] of Object.entries(charts)) {
    const host = byId(id), figure = host.closest("figure") ?? host;
    const width = Math.floor(figure.clientWidth);
    if (!width || host.dataset.width === `${width}`) continue;
    host.dataset.width = width;
    const options = [chart(width) ?? []].flat();
    figure.hidden = !options.length;
    host.replaceChildren(...options.map((each) => picture(plot.plot({ style: { fontSize: "12px", background: "none" }, marginBottom: 42, ...each }), figure)));
  }
}

function notes() {
  const { every, drawn, used, rejected } = data.contacts, total = used + rejected;
  byId("course-note").textContent = (every > 1 ? `${drawn.index.length} of ${total} contacts are drawn: every ${every}th, and those of the largest distances. All statistics are over all contacts. ` : "")
    + "Lines are medians over sections of the log." + (rejected ? " ×: rejected." : "") + (data.fixtures.length > 1 ? " Vertical lines separate fixtures." : "");
  const { correlated, each } = data.parameters;
  const could = each.filter((entry) => entry.sigma != null && !NUISANCE.includes(entry.block)).length;
  byId("correlation-note").textContent = correlated.length < 2 ? "" : `Blue: positive; orange: negative; saturation: size. ${correlated.length < could ? `The first ${correlated.length} of ${could} parameters.` : ""}`;
}

notes();
controls();
draw();
new ResizeObserver(() => requestAnimationFrame(draw)).observe(document.querySelector("main"));
