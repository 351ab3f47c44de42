"use strict";
// The texts and tables of an evaluation's page.

const SCORES = ["mean", "rms", "max"];
const millimetres = (metres) => (metres == null ? "–" : (UNITS.m[0] * metres).toFixed(3));
/** All contacts, then fixture by fixture, of those with contacts, where there are several. */
const rows = data.fixtures.length > 1 ? [data.all, ...data.fixtures.filter((fixture) => fixture.contacts)] : [data.all];

function verdict() {
  const { robot, evaluated, created, status, agrees, is_calibrated, all, warnings } = data;
  document.title = `touchcal evaluation: ${robot}`;
  byId("what").textContent = `Evaluation of ${evaluated}, ${robot}, on ${count(all.contacts, "contact")}`;
  byId("when").textContent = `${created ? `${date(created)}, ` : ""}touchcal ${data.version}`;
  const is_predicted = is_calibrated && agrees != null;
  const unpredicted = status == null ? "Give touchcal evaluate the estimate.json of the calibration to compare them with its covariance."
    : is_calibrated ? "The scatter of these contacts cannot be predicted." : "The calibration has no uncertainty to compare them with.";
  const of_calibration = status === "doubtful" ? "The calibration itself is doubtful, for which its own report gives the reasons. " : "";
  const headline_of_scores = is_predicted ? "Agrees with the prediction" : "Scores without a prediction of the calibration";
  const [state, headline, words] = status === "not_usable" ? ["not_usable", "Not usable: do not use the calibration", "Its own report gives the reasons, however well it does here."]
    : warnings.length ? ["doubtful", "Contradicts the prediction", `${of_calibration}Contacts are farther off than the calibration's covariance and the noise explain. The warnings say where.`]
    : [status === "doubtful" ? "doubtful" : is_predicted ? "usable" : null,
      status === "doubtful" ? "Doubtful: use the calibration with care" : headline_of_scores,
      (status === "doubtful" ? `${headline_of_scores}. ` : "") + of_calibration + (is_predicted ? "Nothing here contradicts the calibration's covariance beyond chance." : unpredicted)];
  byId("verdict").className = state ?? "";
  byId("verdict").append(state ? sign(state) : "", el("div", {}, el("h1", {}, headline), el("p", {}, words)));
  byId("warnings").append(...warningItems(warnings));
}

/** Root mean squares of both arms as bars from the least of all to the largest, on a logarithmic scale. */
function bars({ before, after }, [low, high]) {
  const share = (metres) => Math.max(2, (100 * Math.log(Math.max(low, metres) / low)) / Math.log(high / low || 1));
  const bar = (metres, y, fill) => el("rect", { x: 0, y: `${y}%`, width: `${share(metres)}%`, height: "32%", fill });
  return el("svg", { class: "bars", "aria-hidden": "true" }, bar(before.rms, 14, "var(--before)"), bar(after.rms, 54, "var(--after)"));
}

function scores() {
  const all = rows.flatMap(({ change: { before, after } }) => [before.rms, after.rms]).filter((metres) => metres > 0);
  const reach = [0.5 * Math.min(...all, 1e-3), Math.max(...all, 1e-6)];
  const headings = ["fixture", "#contacts", "#nominal: mean", "#rms", "#max", "#given: mean", "#rms", "#max", "rms"];
  const numbers = ({ before, after }) => [before, after].flatMap((spread) => SCORES.map((what) => spread[what]));
  byId("score-table").append(table(headings, rows.map(({ name, contacts, change }) => [name, `${contacts}`, ...numbers(change).map(millimetres), bars(change, reach)])));
  byId("score-table").after(csv("scores.csv", () => ({
    headings: ["fixture", "contacts", ...["nominal", "given"].flatMap((arm) => SCORES.map((what) => `${arm}_${what}_mm`)), "scatter_found_mm", "scatter_predicted_mm", "found_over_predicted", "by_chance_low", "by_chance_high"],
    rows: [data.all, ...data.fixtures].map(({ name, contacts, change, scatter }) => [name, contacts, ...[...numbers(change), scatter?.found, scatter?.predicted].map((metres) => (metres == null ? "" : UNITS.m[0] * metres)), scatter?.ratio, ...(scatter?.by_chance ?? ["", ""])]),
  })));
}

const source = data.is_calibrated ? "what the calibration leaves uncertain" : "declared tolerances, with an exact arm";

/** Scatter found over predicted, in what chance makes of 1, on an axis from 0 to `most`. */
function ratio({ ratio, by_chance: [low, high], is_exceeded }, most) {
  const x = (value) => `${(100 * value) / most}%`;
  const colour = is_exceeded ? "var(--bad)" : "var(--after)";
  return el("svg", { class: "bars", "aria-hidden": "true" }, el("rect", { x: x(low), width: `${(100 * (high - low)) / most}%`, y: "15%", height: "70%", fill: "var(--prior)" }),
    el("line", { x1: x(1), x2: x(1), y1: 0, y2: "100%", stroke: "var(--soft)" }), el("circle", { cx: x(ratio), cy: "50%", r: 4, fill: colour }));
}

function scatter() {
  byId("scatter").hidden = rows.every((row) => !row.scatter);
  byId("scatter-words").textContent = `Root mean square distances, beside those predicted from noise and ${source}. Pale band: what chance makes of 1 in 99.9 % of cases, if the prediction is right.`;
  const most = 1.05 * Math.max(...rows.flatMap(({ scatter }) => (scatter ? [scatter.ratio, scatter.by_chance[1]] : [])));
  const row = ({ name, scatter }) => (scatter ? [name, millimetres(scatter.found), millimetres(scatter.predicted), scatter.ratio.toFixed(3), scatter.by_chance.map((value) => value.toFixed(3)).join(" to "), ratio(scatter, most), scatter.is_exceeded ? "more than chance" : ""]
    : [name, ...Array(4).fill("–"), "", ""]);
  byId("scatter-table").append(table(["fixture", "#found mm", "#predicted mm", "#found/predicted", "#by chance (99.9 %)", "found/predicted", ""], rows.map(row)));
}

function distances() {
  const { distances, common_strain } = data;
  byId("distances").hidden = !distances.length;
  const strain = common_strain ? ` Strain common to all: ${signed(100 * common_strain[0], 3)} ± ${(100 * common_strain[1]).toFixed(3)} %.` : "";
  byId("distance-words").textContent = `With noise and ${source}.${strain}`;
  const row = ({ between, source, declared, found, difference, sigma, deviations }) => [between.join(" – "), source, millimetres(declared), millimetres(found), signed(UNITS.m[0] * difference, 3), millimetres(sigma), signed(deviations, 1)];
  byId("distance-table").append(table(["between", "declared by", "#declared mm", "#found mm", "#difference mm", "#± sigma mm", "#difference/sigma"], distances.map(row)));
  byId("distance-table").after(csv("distances.csv", () => ({
    headings: ["from", "to", "declared_by", "declared_mm", "found_mm", "sigma_mm"],
    rows: distances.map(({ between, source, declared, found, sigma }) => [...between, source, ...[declared, found, sigma].map((metres) => UNITS.m[0] * metres)]),
  })));
}

function truth() {
  byId("truth").hidden = !data.tool_errors.length;
  const row = ({ name, unit, nominal, given }) => {
    const [factor, symbol] = UNITS[unit];
    return [name, ...[...nominal, ...given].map((value) => (factor * value).toFixed(unit === "m" ? 3 : 4)), symbol];
  };
  byId("truth-table").append(table(["", "#nominal: rms", "#max", "#given: rms", "#max", "unit"], data.tool_errors.map(row)));
}

for (const part of [verdict, scores, scatter, distances, truth, contents]) part();
byId("inputs").append(inputTable());
document.documentElement.dataset.drawn = "all";
