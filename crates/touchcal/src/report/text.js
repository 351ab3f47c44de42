"use strict";
// The texts and tables of a calibration's page.

const BLOCKS = {
  strain: "Strain common to all links", segment_strain: "Additional strain of each segment", joint_offset: "Encoder offsets", joint_origin: "Joint origins",
  joint_compliance: "Joint compliance", joint_backlash: "Half of the play of each joint", tool: "Pose of the tool on the tip", fixture: "Poses of the fixtures", gap_bias: "Gap bias: mean measured gap at contact",
  joint_drift: "Drift of encoder offsets between placements", joint_trend: "Trend of encoder offsets over the log",
  wrench_bias: "Bias of the measured wrench, in the tip frame", wrench_scale: "Relative error of the measured wrench's scale",
};
/** Blocks of nuisance parameters. */
const NUISANCE = ["gap_bias", "joint_drift", "joint_trend", "wrench_bias", "wrench_scale"];

function place(contact) {
  return `${data.contacts.files[contact.file] ?? "?"}, line ${contact.line}`;
}

function verdict() {
  const { robot, status, acceptance, warnings, contacts, parameters, all } = data;
  document.title = `touchcal: ${robot.name}`;
  byId("what").textContent = `Calibration of ${robot.name}, ${robot.joints} joints from ${robot.base} to ${robot.tip}`;
  byId("when").textContent = `${data.created ? `${date(data.created)}, ` : ""}touchcal ${data.version}`;
  const reason = data.termination.reason.replaceAll("_", " ");
  const texts = {
    usable: ["Usable", "Residuals at the contacts used for calibration underestimate the error; evaluate the result on other contacts with touchcal evaluate."],
    doubtful: ["Doubtful: use the result with care", "Contacts contradict something, for which standard deviations allow, or they are few, for which these do not; the warnings say which. Evaluate the result on other contacts with touchcal evaluate."],
    not_usable: ["Not usable: do not use the result", data.termination.reason === "converged"
      ? "The contacts do not determine the arm, or contradict the problem file. The warnings give the reasons."
      : `The search ended without reaching a minimum (${reason}). The page shows its last state.`],
  };
  // A usable calibration may be too inaccurate for what is asked of it.
  const forTask = status === "not_usable" ? null : { fail: ["not_usable", "not for this task"], undecided: ["doubtful", "undecided for this task"] }[acceptance?.decision];
  const [headline, next] = texts[status];
  const appearance = forTask?.[0] ?? status;
  byId("verdict").className = appearance;
  const also = status === "usable" && warnings.length ? ` See ${warnings.length === 1 ? "the caution" : `the ${warnings.length} cautions`}.` : "";
  const words = el("div", {}, el("h1", {}, forTask ? `${status === "usable" ? "Usable, but" : "Doubtful, and"} ${forTask[1]}` : headline), el("p", {}, next + also));
  byId("verdict").append(sign(appearance), words);
  if (acceptance) words.append(el("p", { class: "acceptance" }, el("strong", {}, acceptance.message), ` → ${acceptance.advice}`));
  byId("warnings").append(...warningItems(warnings));
  const figure = (name, value, note) => el("div", {}, el("dt", {}, name), el("dd", {}, value, el("small", {}, note)));
  const heldOut = data.held_out;
  const expected = status === "not_usable" ? null : data.expected;
  const length = (metres) => `${(UNITS.m[0] * metres).toFixed(3)} mm`, angle = (radians) => `${(UNITS.rad[0] * radians).toFixed(3)}°`;
  const error = (name, words) => (expected ? figure(name, ...words(expected)) : figure(name, "–", status === "not_usable" ? "the result is not usable" : "not known"));
  byId("figures").append(
    error("Expected tool error in base", (tool) => [length(tool.position), `${angle(tool.angle)}; before: ${length(tool.nominal_position)}, ${angle(tool.nominal_angle)}; root mean square over the workspace`]),
    error("Between two positions", (tool) => [length(tool.distance), `before: ${length(tool.nominal_distance)}; root mean square over the workspace`]),
    figure("Distance from contact", contacts.used + contacts.rejected ? `${significant(1e3 * all.before.rms)} → ${significant(1e3 * all.after.rms, 2)} mm` : "–", "root mean square, before and after"),
    contacts.used_by_descent == null
      ? figure("Contacts", `${contacts.used} used`, `${contacts.rejected} rejected, ${count(contacts.read, "row")} read`)
      : figure("Contacts", `${contacts.used_by_descent} used`, `by the descent; ${contacts.rejected} of all do not fit its result, ${count(contacts.read, "row")} read`),
    parameters.unknown ? figure("Identifiable", "–", parameters.unknown) : figure("Identifiable", `${parameters.rank} of ${parameters.singular_values.length}`, "directions, from the contacts alone"),
    heldOut ? figure("Held-out contacts", `${significant(heldOut.ratio)} times the predicted scatter`, `${count(heldOut.contacts, "contact")}, by chance up to ${significant(heldOut.by_chance)}`) : "",
  );
}

function fixtures() {
  const row = ({ name, contacts, rejected, contact, change: { before, after } }) =>
    [name, contact, `${contacts}`, `${rejected}`, ...[before, after].flatMap(({ mean, rms, max }) => [mean, rms, max].map((v) => (1e3 * v).toFixed(3)))];
  const headings = ["fixture", "contact model", "#contacts", "#rejected", "#before: mean mm", "#rms mm", "#max mm", "#after: mean mm", "#rms mm", "#max mm"];
  const { read, used, rejected } = data.contacts;
  const touched = data.fixtures.filter((fixture) => fixture.contacts);
  byId("fixture-table").append(table(headings, [...touched, { name: "all", contact: "", contacts: used + rejected, rejected, change: data.all }].map(row)));
  byId("fixture-table").after(csv("fixtures.csv", () => ({
    headings: ["fixture", "contact_model", "contacts", "rejected", ...["before", "after"].flatMap((when) => ["mean", "rms", "max"].map((what) => `${when}_${what}_mm`))],
    rows: touched.map((fixture) => [fixture.name, fixture.contact, fixture.contacts, fixture.rejected, ...["before", "after"].flatMap((when) => ["mean", "rms", "max"].map((what) => 1e3 * fixture.change[when][what]))]),
  })));
}

/** A value with its standard deviation in units for people. */
function valueOf({ name, unit, value, sigma }, effect, is_declared) {
  const [factor, symbol] = UNITS[unit];
  const decimals = Math.min(7, Math.max(0, 1 - Math.floor(Math.log10(factor * (sigma || Math.abs(value) || 1)))));
  const label = name.startsWith(effect + ".") ? name.slice(effect.length + 1) : name;
  if (name === "noise") return `${value.toFixed(2)} ± ${sigma.toFixed(2)} times the declared`;
  if (is_declared) {
    const side = value > 0 ? "apart" : "overlapping";
    const found = name.startsWith("gap_bias.") ? `${(factor * Math.abs(value)).toFixed(decimals)} ${symbol} ${side} at contact` : `${signed(factor * value, decimals)} ${symbol}`;
    return `${label} ${found} (declared ${sigma ? `± ${(factor * sigma).toFixed(decimals)}` : "exact"})`;
  }
  return `${label} ${signed(factor * value, decimals)} ± ${(factor * sigma).toFixed(decimals)} ${symbol}`;
}

function declarations() {
  const { effects, declared, untested, minima, notes, allows_for_unseen_effects } = data.declarations;
  const shown = [...effects, ...declared].filter((test) => test.is_significant);
  const others = (tests) => tests.filter((test) => !test.is_significant).map(({ name }) => name).join(", ");
  const sentences = effects.length ? [] : ["Effects that the model leaves out were not tested: the search did not converge, or contacts have no likelihood with a minimum here."];
  if (shown.length) sentences.push("Contacts speak against these lines of the problem file (p below 0.001, or one value far from what is declared; the warnings say which have consequences). Values of effects that the model leaves out are what they would be if they were estimated, those of what is declared the estimates less the declared values, the most standard deviations off first; p is the probability that it is chance, corrected for the number of tests; the tool moves by as much between the result and one without the effect, or with what is declared held exact.");
  if (others(effects)) sentences.push(`Contacts do not contradict that these effects are zero: ${others(effects)}.`);
  if (others(declared)) sentences.push(`Contacts do not contradict the standard deviations of these declarations: ${others(declared)}.`);
  if (untested.length) sentences.push(`Contacts cannot tell whether these are as declared: ${untested.join(", ")}.`);
  if (effects.length && allows_for_unseen_effects) sentences.push("Intervals allow for errors of the arm that contacts would not show.");
  byId("effect-words").textContent = sentences.join(" ");
  const lines = (texts) => texts.map((text) => el("div", {}, text));
  const row = ({ name, description, remedy, declared_in, p_value, values, displacement, radius }) => {
    const is_declared = radius === null;
    const [first, rest] = [values.slice(0, 3), values.slice(3)].map((some) => lines(some.map((value) => valueOf(value, name, is_declared))));
    const more = rest.length ? el("details", {}, el("summary", {}, `and ${rest.length} more`), ...rest) : null;
    const told = (text, note) => el("div", {}, text, el("small", {}, note));
    const [motion, region] = [displacement, radius].map((length) => (length === null ? "–" : (1e3 * length).toFixed(3)));
    return [told(name, description), p_value, el("div", {}, ...first, more), motion, region, told(declared_in, `→ ${remedy}`)];
  };
  const headings = ["left out or declared", "#p", "value", "#moves the tool (mm)", "#95 % region (mm)", "problem file"];
  if (shown.length) byId("effect-table").append(table(headings, shown.map(row)));
  const minimum = ({ tool_distance, cost_ratio, parameter, unit, there, here }) => {
    const [factor, symbol] = UNITS[unit];
    return [(1e3 * tool_distance).toFixed(1), cost_ratio.toFixed(2), parameter, ...[there, here].map((value) => `${signed(factor * value, 4)} ${symbol}`)];
  };
  const places = ["#distance of the tool (mm)", "#cost over that of the result", "differs most in", "#there", "#in the result"];
  if (minima.length) byId("minima").append(el("p", {}, "Searches from other starts end in other minima, which contacts do not rule out:"), table(places, minima.map(minimum)));
  if (notes.length) byId("assumptions").append(el("p", { class: "note" }, "Assumed in reading the problem file and its logs:"), el("ul", {}, ...notes.map((note) => el("li", {}, note))));
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

/** Parameters of one kind, in the columns of the terminal, with their intervals on a common scale. */
function parameterTable(entries, title) {
  const [factor, unit, decimals] = UNITS[entries[0].unit];
  const ends = entries.flatMap(({ value, sigma }) => [value - 1.96 * (sigma ?? 0), value + 1.96 * (sigma ?? 0)]);
  const reach = [Math.min(0, ...ends), Math.max(0, ...ends)];
  const room = 0.04 * (reach[1] - reach[0] || 1e-9);
  const domain = [reach[0] - room, reach[1] + room];
  const tick = (value) => el("span", { style: `left: ${(100 * (value - domain[0])) / (domain[1] - domain[0])}%` }, significant(factor * value, 2));
  const near = (value) => Math.abs(value) < 0.2 * (domain[1] - domain[0]);
  const scale = el("div", { class: "scale" }, ...[reach[0], 0, reach[1]].filter((value, i) => i === 1 || (value !== 0 && !near(value))).map(tick));
  const number = (value) => el("td", { class: "number" }, value == null ? "–" : (factor * value).toFixed(decimals));
  const row = (entry) => {
    const { name, description, block, value, sigma, prior_sigma, undetermined } = entry;
    const label = name.startsWith(block + ".") ? name.slice(block.length + 1) : name;
    const cells = [el("td", { class: "name" }, label), el("td", { class: "number" }, signed(factor * value, decimals)), number(sigma), number(prior_sigma),
      el("td", { class: "unit" }, unit), el("td", { class: "interval" }, interval(entry, domain))];
    const made = el("tr", { class: undetermined ? "undetermined" : null, title: description }, ...cells);
    return undetermined ? [made, el("tr", { class: "why" }, el("td", { colspan: cells.length }, undetermined))] : [made];
  };
  const heading = (words, kind) => el("th", { class: kind, scope: "col" }, words);
  const head = el("tr", {}, heading("parameter", "name"), ...["value", "± sigma", "prior"].map((words) => heading(words, "number")), heading("unit", "unit"), heading(scale, "interval"));
  return el("table", { class: "parameters" }, el("caption", {}, `${title} (${unit})`), el("thead", {}, head), el("tbody", {}, ...entries.flatMap(row)));
}

/** Tables of parameters, one of each block and unit. */
function parameterTables(entries) {
  const groups = new Map();
  for (const entry of entries) {
    const group = `${entry.block} ${entry.unit}`;
    groups.set(group, [...(groups.get(group) ?? []), entry]);
  }
  return [...groups.values()].map((group) => parameterTable(group, BLOCKS[group[0].block] ?? group[0].block));
}

function parameters() {
  const { each } = data.parameters;
  const is_measured = (entry) => !entry.undetermined && !NUISANCE.includes(entry.block);
  const [measured, others] = [each.filter(is_measured), each.filter((entry) => !is_measured(entry))];
  const open = others.filter((entry) => entry.undetermined).length, nuisance = others.length - open;
  const kinds = [open ? `${open} that the contacts do not determine` : "", nuisance ? count(nuisance, "nuisance parameter") : ""].filter(Boolean);
  byId("parameter-tables").append(measured.length ? "" : el("p", {}, "The contacts determine no parameter of the arm, the tool or the fixtures."), ...parameterTables(measured));
  if (others.length) byId("parameter-tables").append(el("details", {}, el("summary", {}, `Other parameters: ${kinds.join(", ")}`), ...parameterTables(others)));
  byId("parameter-tables").append(csv("parameters.csv", () => ({
    headings: ["parameter", "value", "sigma", "prior", "unit", "identifiable"],
    rows: each.map(({ name, value, sigma, prior_sigma, unit, undetermined }) => {
      const [factor, symbol] = UNITS[unit];
      return [name, ...[value, sigma, prior_sigma].map((number) => (number == null ? "" : factor * number)), symbol, data.parameters.unknown ? "" : undetermined ? "no" : "yes"];
    }),
  })));
}

function determined() {
  const { rank, singular_values, condition, null_space, each, unknown } = data.parameters;
  if (unknown) {
    byId("determined-words").textContent = `What the contacts determine is ${unknown}.`;
    return;
  }
  const left = each.filter((entry) => entry.undetermined && !NUISANCE.includes(entry.block));
  byId("determined-words").textContent = `The contacts alone determine ${rank} of ${count(singular_values.length, "direction")} of the parameter space`
    + (condition == null ? "." : ` (condition number ${significant(condition, 2)}).`)
    + (left.length ? ` ${count(left.length, "parameter")} of the arm, the tool or the fixtures ${left.length === 1 ? "is" : "are"} determined by the prior, or fixed.` : "");
  if (null_space.length) {
    const list = (texts) => el("ul", {}, ...texts.map((text) => el("li", {}, text)));
    const shown = 8;
    byId("null-space").append(el("p", { class: "note" }, "Directions that are not identifiable (the data add less than the prior):"), list(null_space.slice(0, shown)));
    const more = null_space.slice(shown);
    if (more.length) byId("null-space").append(el("details", {}, el("summary", {}, `and ${more.length} more`), list(more)));
  }
}

function uncertainty() {
  const { uncertainty, warnings, parameters } = data;
  if (!uncertainty) {
    byId("uncertainty-words").textContent = "Distances to a projection give no uncertainty.";
    return;
  }
  const fixed = parameters.each.some((entry) => entry.undetermined?.startsWith("fixed"));
  const middle = (values) => quantile(values, 0.5);
  byId("uncertainty-words").textContent = `Standard deviations from the estimate's covariance, at ${uncertainty.workspace.length} joint positions across the workspace and at a contact `
    + `with each fixture. Medians, where the head of the report has root mean squares: tool position in base ${mm(middle(uncertainty.workspace.map((pose) => pose.position)), 2)}, orientation `
    + `${deg(middle(uncertainty.workspace.map((pose) => pose.angle)))}. Distance between two positions, which is independent of the base, ${mm(middle(uncertainty.distances), 2)}.`
    + (fixed ? " Fixed parameters are included with a large plausible error, such as 5° or 5 %." : "");
}

/** Rows that the residual of a kind of contact has; others have three. */
const ROWS = { gap: 1, distance: 1, none: 0 };
/** The contacts that are drawn: where each was read, joint positions, distances, kind and rows of the residual. */
function contactRows() {
  const { drawn, files } = data.contacts, { q, calibrated } = data.scene;
  const joints = calibrated.joints.filter(({ kind }) => kind !== "fixed");
  const [[toDeg], [toMm]] = [UNITS.rad, UNITS.m];
  const position = (value, j) => (joints[j].kind === "slides" ? toMm : toDeg) * value;
  return {
    headings: ["file", "line", "fixture", ...joints.map(({ name, kind }) => `${name}_${kind === "slides" ? "mm" : "deg"}`), "before_mm", "after_mm", "residual", ...[1, 2, 3].map((row) => `residual_${row}_mm`), "rejected"],
    rows: drawn.index.map((_, k) => {
      const { name, residual } = data.fixtures[drawn.fixture[k]];
      const rows = drawn.residual[k].map((row, i) => (i < (ROWS[residual] ?? 3) ? toMm * row : ""));
      return [files[drawn.file[k]], drawn.line[k], name, ...q[k].map(position), toMm * drawn.before[k], toMm * drawn.after[k], residual, ...rows, drawn.rejected[k]];
    }),
  };
}

function outliers() {
  byId("course-note").after(csv("contacts.csv", contactRows));
  const { outliers, rejected, used, used_by_descent } = data.contacts;
  const share = (100 * rejected) / Math.max(1, rejected + used);
  const verdict = used_by_descent == null ? `${rejected === 1 ? "was" : "were"} rejected as outliers` : `${rejected === 1 ? "does" : "do"} not fit where the descent ended`;
  byId("outlier-words").textContent = rejected
    ? `${count(rejected, "contact")} (${significant(share, 2)} %) ${verdict}`
      + (outliers.length < rejected ? `; the ${outliers.length} largest are listed.` : ".") + " Line numbers start at 1."
    : `${used ? "No contact was rejected." : "There are no contacts."} ${outliers.length ? `The ${outliers.length} largest distances:` : ""}`;
  const row = (contact) => [data.contacts.files[contact.file] ?? "?", `${contact.line}`, data.fixtures[contact.fixture].name, (1e3 * contact.after).toFixed(3),
    ...(rejected ? [significant(contact.deviations, 2)] : [])];
  if (outliers.length) byId("outlier-table").append(table(["file", "#line", "fixture", "#distance mm", ...(rejected ? ["#standard deviations"] : [])], outliers.map(row)));
}

/** What was chosen: method, noise and priors. */
function settings() {
  const { method, declared, found, is_estimated, factor } = data.settings;
  const [[toDeg], [toMm]] = [UNITS.rad, UNITS.m];
  const noise = ({ encoder, contact }) => `encoders ${significant(toDeg * encoder, 2)} deg, contacts ${significant(toMm * contact, 2)} mm`;
  const priors = new Map();
  for (const { block, unit, prior_sigma } of data.parameters.each) {
    const [factor, symbol] = UNITS[unit];
    const words = prior_sigma == null ? "none" : `${significant(factor * prior_sigma, 2)} ${symbol}`;
    priors.set(block, new Set([...(priors.get(block) ?? []), words]));
  }
  const range = (words) => (words.length > 3 ? `${words.slice(0, 3).join(", ")} and ${words.length - 3} others` : words.join(", "));
  const rows = [["method", method], [is_estimated ? "noise, initial" : "noise, declared", noise(declared)],
    [is_estimated ? "noise, estimated" : "noise, found", `${noise(found)} (${significant(factor, 3)} times)`],
    ...[...priors].map(([block, words]) => [`prior sigma: ${(BLOCKS[block] ?? block).toLowerCase()}`, range([...words])])];
  byId("settings").append(table(["setting", "value"], rows));
}

function inputs() {
  byId("inputs").append(inputTable());
  byId("version").textContent = `Written by touchcal ${data.version}${data.created ? ` on ${date(data.created)}` : ""}. Charts by Observable Plot, three-dimensional view by three.js; both are embedded.`;
}

function search() {
  const { reason, measured, threshold, iterations } = data.termination;
  const how = reason === "converged" ? "converged" : `stopped: ${reason.replaceAll("_", " ")}`;
  byId("convergence-words").textContent = `The search ${how} after ${count(iterations, "step")}; termination criterion: ${significant(measured, 2)}, threshold ${significant(threshold, 2)}. `
    + "It consists of several minimisations: coarse ones on the manifolds' envelopes, then fine ones with an increasing number of contacts and a decreasing scale of the loss. Each has a chart and an axis of its own, because costs of different minimisations are not comparable.";
}

for (const part of [verdict, fixtures, declarations, parameters, determined, uncertainty, outliers, settings, inputs, search, contents]) part();

// The libraries and the scripts that use them run one by one after the text has been painted.
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
