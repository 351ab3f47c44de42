"use strict";
// The page's words and tables, and what the other scripts share: the data, elements, and numbers for people.

const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);

/** An element; attributes that are null are left out, text only ever becomes text. */
function el(name, attributes = {}, ...children) {
  const svg = ["svg", "line", "circle", "rect"].includes(name);
  const node = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) if (value != null) node.setAttribute(key, value);
  node.append(...children.filter((child) => child != null));
  return node;
}

/** A number to so many significant digits, without an exponent, with a true minus. */
function significant(value, digits = 3) {
  if (value == null) return "–";
  return value.toLocaleString("en", { maximumSignificantDigits: digits, useGrouping: false }).replace("-", "−");
}
function signed(value, decimals) {
  const size = Math.abs(value).toFixed(decimals);
  return Number(size) === 0 ? size : (value < 0 ? "−" : "+") + size;
}
const mm = (metres, digits = 3) => (metres == null ? "–" : `${significant(1e3 * metres, digits)} mm`);
const deg = (radians) => (radians == null ? "–" : `${significant((radians * 180) / Math.PI, 2)}°`);
const count = (number, one, many = one + "s") => `${number} ${number === 1 ? one : many}`;
function quantile(values, share) {
  const sorted = Float64Array.from(values).sort();
  return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] : null;
}

/** Factor from SI and name of a unit for people. */
const UNITS = { m: [1e3, "mm"], rad: [180 / Math.PI, "°"], "rad/(N m)": [1e6, "µrad/(N m)"], 1: [100, "%"] };
const BLOCKS = {
  strain: "Strain common to all links", segment_strain: "Strain of each segment", joint_offset: "Zeros of the encoders", joint_origin: "Origins of the joints",
  joint_compliance: "Compliance of the joints", tool: "Tool on the tip", fixture: "Places of the fixtures", interference: "Interference: mean gap at contact",
  joint_drift: "Drift of the zeros between placements",
};
/** What passes, and is no part of the arm. */
const PASSING = ["interference", "joint_drift"];

function place(contact) {
  return `${data.contacts.files[contact.file] ?? "?"}, line ${contact.line}`;
}

function verdict() {
  const { robot, status, warnings, contacts, parameters, all } = data;
  document.title = `touchcal: ${robot.name}`;
  byId("what").textContent = `Calibration of ${robot.name}, ${robot.joints} joints from ${robot.base} to ${robot.tip}`;
  const reason = data.termination.reason.replaceAll("_", " ");
  const words = {
    converged: ["✓ Converged: use it", "Residuals at the contacts it was fitted to flatter; score it on others with touchcal evaluate."],
    not_converged: ["✕ Not converged: do not use it", `The search ended without reaching a minimum (${reason}). What follows is where it stood.`],
    not_usable: ["✕ Not usable: do not use it", "The contacts do not determine the arm, or contradict what was declared. The reasons are below."],
  };
  const [headline, next] = words[status];
  byId("verdict").className = status === "converged" ? "good" : "bad";
  const also = status === "converged" && warnings.length ? ` Mind ${warnings.length === 1 ? "the warning" : `the ${warnings.length} warnings`}.` : "";
  byId("verdict").append(el("h1", {}, headline), el("p", {}, next + also));
  byId("warnings").append(...warnings.map((warning) => el("li", {}, warning.words, el("span", {}, `→ ${warning.advice}`))));
  const figure = (name, value, note) => el("div", {}, el("dt", {}, name), el("dd", {}, value, el("small", {}, note)));
  const between = data.uncertainty && quantile(data.uncertainty.distances, 0.5);
  byId("figures").append(
    figure("Distance from touching", contacts.used + contacts.rejected ? `${significant(1e3 * all.before.rms)} → ${significant(1e3 * all.after.rms, 2)} mm` : "–", "root mean square, before and after"),
    figure("Contacts", `${contacts.used} counted`, `${contacts.rejected} rejected, ${count(contacts.read, "row")} read`),
    figure("Determined", `${parameters.rank} of ${parameters.singular_values.length}`, "directions, by the contacts alone"),
    figure("Tool, between two poses", data.uncertainty ? `± ${mm(between, 2)}` : "–", data.uncertainty ? "standard deviation of the distance, median" : "no uncertainty follows from a projection"),
  );
}

/** A table from headings and rows of cells; a heading that starts with # is of numbers. */
function table(headings, rows) {
  const kind = (heading) => (heading.startsWith("#") ? "number" : null);
  const head = el("tr", {}, ...headings.map((heading) => el("th", { class: kind(heading) }, heading.replace("#", ""))));
  const body = rows.map((cells) => el("tr", {}, ...cells.map((cell, i) => el("td", { class: kind(headings[i]) ?? (i === 0 ? "name" : null) }, cell))));
  return el("table", {}, el("thead", {}, head), el("tbody", {}, ...body));
}

function fixtures() {
  const row = ({ name, contacts, rejected, touch, change: { before, after } }) =>
    [name, touch, `${contacts}`, `${rejected}`, ...[before, after].flatMap(({ mean, rms, max }) => [mean, rms, max].map((v) => (1e3 * v).toFixed(3)))];
  const headings = ["fixture", "touch", "#contacts", "#rejected", "#before: mean mm", "#rms mm", "#max mm", "#after: mean mm", "#rms mm", "#max mm"];
  const { read, used, rejected } = data.contacts;
  byId("fixture-table").append(table(headings, [...data.fixtures, { name: "all", touch: "", contacts: used + rejected, rejected, change: data.all }].map(row)));
}

/** A parameter's 95 % interval, its prior's band and zero, between `low` and `high` (SI). */
function interval({ value, sigma, prior_sigma, undetermined }, [low, high]) {
  const x = (v) => `${(100 * (Math.min(high, Math.max(low, v)) - low)) / (high - low)}%`;
  const colour = undetermined ? "var(--soft)" : "var(--after)";
  const svg = el("svg", { role: "img", "aria-hidden": "true" });
  if (prior_sigma) {
    const [from, to] = [-1.96, 1.96].map((k) => parseFloat(x(k * prior_sigma)));
    svg.append(el("rect", { x: `${from}%`, width: `${to - from}%`, y: "15%", height: "70%", fill: "var(--prior)" }));
  }
  svg.append(el("line", { x1: x(0), x2: x(0), y1: 0, y2: "100%", stroke: "var(--soft)", "stroke-width": 1 }));
  if (sigma) svg.append(el("line", { x1: x(value - 1.96 * sigma), x2: x(value + 1.96 * sigma), y1: "50%", y2: "50%", stroke: colour, "stroke-width": 2 }));
  svg.append(el("circle", { cx: x(value), cy: "50%", r: 3.5, fill: undetermined ? "var(--paper)" : colour, stroke: colour, "stroke-width": 1.5 }));
  return svg;
}

function parameterTable(entries, title) {
  const [factor, unit] = UNITS[entries[0].unit];
  const ends = entries.flatMap(({ value, sigma }) => [value - 1.96 * (sigma ?? 0), value + 1.96 * (sigma ?? 0)]);
  const reach = [Math.min(0, ...ends), Math.max(0, ...ends)];
  const room = 0.04 * (reach[1] - reach[0] || 1e-9);
  const domain = [reach[0] - room, reach[1] + room];
  const tick = (value) => el("span", { style: `left: ${(100 * (value - domain[0])) / (domain[1] - domain[0])}%` }, significant(factor * value, 2));
  const near = (value) => Math.abs(value) < (innerWidth < 640 ? 0.35 : 0.12) * (domain[1] - domain[0]);
  const scale = el("div", { class: "scale" }, ...[reach[0], 0, reach[1]].filter((value, i) => i === 1 || (value !== 0 && !near(value))).map(tick));
  const row = (entry) => {
    const { name, words, block, value, sigma, undetermined } = entry;
    const decimals = Math.min(7, Math.max(0, sigma ? 1 - Math.floor(Math.log10(factor * sigma)) : 4));
    const number = signed(factor * value, decimals) + (sigma ? ` ± ${(factor * sigma).toFixed(decimals)}` : "");
    const label = name.startsWith(block + ".") ? name.slice(block.length + 1) : name;
    const made = el("tr", { class: undetermined ? "undetermined" : null, title: words }, el("td", { class: "name" }, label), el("td", { class: "number" }, number),
      el("td", { class: "interval" }, interval(entry, domain)));
    return undetermined ? [made, el("tr", { class: "why" }, el("td", { colspan: 3 }, undetermined))] : [made];
  };
  const head = el("tr", {}, el("th", { class: "name" }, "parameter"), el("th", { class: "number" }, "estimate ± σ"), el("th", { class: "interval" }, scale));
  return el("table", { class: "parameters" }, el("caption", {}, `${title} (${unit})`), el("thead", {}, head), el("tbody", {}, ...entries.flatMap(row)));
}

function parameters() {
  const groups = Map.groupBy
    ? Map.groupBy(data.parameters.each, ({ block, unit }) => `${block} ${unit}`)
    : data.parameters.each.reduce((map, entry) => map.set(`${entry.block} ${entry.unit}`, [...(map.get(`${entry.block} ${entry.unit}`) ?? []), entry]), new Map());
  const host = byId("parameter-tables");
  for (const entries of groups.values()) {
    const { block } = entries[0];
    const made = parameterTable(entries, BLOCKS[block] ?? block);
    host.append(PASSING.includes(block) ? el("details", {}, el("summary", {}, `${BLOCKS[block]} (${entries.length})`), made) : made);
  }
}

function determined() {
  const { rank, singular_values, condition, null_space, each } = data.parameters;
  const left = each.filter((entry) => entry.undetermined && !PASSING.includes(entry.block));
  byId("determined-words").textContent = `The contacts alone determine ${rank} of ${count(singular_values.length, "direction")} in which parameters may change`
    + (condition == null ? "." : ` (condition number ${significant(condition, 2)}).`)
    + (left.length ? ` ${count(left.length, "parameter")} of the arm, the tool or the fixtures ${left.length === 1 ? "is" : "are"} left to the prior, or held.` : "");
  if (null_space.length) {
    const list = (words) => el("ul", {}, ...words.map((text) => el("li", {}, text)));
    const shown = 8;
    byId("null-space").append(el("p", { class: "note" }, "About these the contacts alone say less than was known before:"), list(null_space.slice(0, shown)));
    const more = null_space.slice(shown);
    if (more.length) byId("null-space").append(el("details", {}, el("summary", {}, `and ${more.length} more`), list(more)));
  }
}

function uncertainty() {
  const { uncertainty, warnings, parameters } = data;
  if (!uncertainty) {
    byId("uncertainty-words").textContent = "No uncertainty follows from distances to a projection.";
    return;
  }
  const held = parameters.each.some((entry) => entry.undetermined?.startsWith("held"));
  const middle = (values) => quantile(values, 0.5);
  byId("uncertainty-words").textContent = `Standard deviations that follow from the estimate's covariance, at ${uncertainty.workspace.length} poses spread over the joints' limits and at a contact `
    + `with each fixture. In base, the tool's place is typically known to ${mm(middle(uncertainty.workspace.map((pose) => pose.position)), 2)} and its direction to `
    + `${deg(middle(uncertainty.workspace.map((pose) => pose.angle)))}. Distances between two places need no base: they are known to ${mm(middle(uncertainty.distances), 2)}.`
    + (held ? " Parameters that were held count with the size of a large but plausible error, such as 5° or 5 %." : "");
}

function outliers() {
  const { listed, rejected, used } = data.contacts;
  const share = (100 * rejected) / Math.max(1, rejected + used);
  byId("outlier-words").textContent = rejected
    ? `${count(rejected, "contact")} (${significant(share, 2)} %) did not fit and ${rejected === 1 ? "was" : "were"} rejected`
      + (listed.length < rejected ? `; the ${listed.length} worst are listed.` : ".") + " Lines are those of the file, counted from 1."
    : `${used ? "None was rejected." : "There are none."} ${listed.length ? `The ${listed.length} that are farthest from touching, for a look:` : ""}`;
  const row = (contact) => [data.contacts.files[contact.file] ?? "?", `${contact.line}`, data.fixtures[contact.fixture].name, (1e3 * contact.after).toFixed(3),
    ...(rejected ? [significant(contact.deviations, 2)] : [])];
  if (listed.length) byId("outlier-table").append(table(["file", "#line", "fixture", "#distance mm", ...(rejected ? ["#standard deviations"] : [])], listed.map(row)));
}

function inputs() {
  byId("inputs").append(table(["file", "SHA-256"], data.inputs.map(({ path, sha256 }) => [path, sha256])));
  byId("inputs").querySelectorAll("td:last-child").forEach((cell) => cell.classList.add("hash"));
  byId("version").textContent = `Written by touchcal ${data.version}. Charts by Observable Plot, the picture in space by three.js; both are in this file, which loads nothing.`;
}

function search() {
  const { reason, measured, threshold, iterations } = data.termination;
  const how = reason === "converged" ? "converged" : `stopped: ${reason.replaceAll("_", " ")}`;
  byId("convergence-words").textContent = `It ${how} after ${count(iterations, "step")}; what was left to gain, ${significant(measured, 2)}, is compared with ${significant(threshold, 2)}. `
    + "It is a chain of minimisations: coarse ones towards where contacts can be, then onto them, with more contacts and a stricter loss from one to the next. Each line is one of them; costs compare within a line only."
    + ` Contacts scatter ${significant(data.noise_factor, 2)} times the noise ${data.learned_noise ? "learned" : "declared"}.`;
}

for (const part of [verdict, fixtures, parameters, determined, uncertainty, outliers, inputs, search]) part();

// The libraries and what draws with them come once the words can be seen, one after the other.
function later() {
  const next = document.querySelector("script.later");
  if (!next) {
    document.documentElement.dataset.drawn = "all";
    return;
  }
  next.replaceWith(el("script", {}, next.textContent));
  setTimeout(later);
}
requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(later)));
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((node) => (node.open = true)));
