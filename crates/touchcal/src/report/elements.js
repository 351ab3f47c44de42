"use strict";
// What the scripts of all pages share: the data, elements, formatted numbers, tables and their files, contents.

const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);

/** An element; attributes that are null are left out, text only ever becomes text. */
function el(name, attributes = {}, ...children) {
  const svg = ["svg", "line", "circle", "rect", "path"].includes(name);
  const node = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) if (value != null) node.setAttribute(key, value);
  node.append(...children.filter((child) => child != null));
  return node;
}

/** A number to so many significant digits, with an exponent below a millionth, with a true minus. */
function significant(value, digits = 3) {
  if (value == null) return "–";
  const isTiny = value !== 0 && Math.abs(value) < 1e-6;
  const text = isTiny
    ? value.toExponential(digits - 1)
    : value.toLocaleString("en", { maximumSignificantDigits: digits, useGrouping: false });
  return text.replaceAll("-", "−");
}
function signed(value, decimals) {
  const size = Math.abs(value).toFixed(decimals);
  return Number(size) === 0 ? size : (value < 0 ? "−" : "+") + size;
}
const mm = (metres, digits = 3) => (metres == null ? "–" : `${significant(1e3 * metres, digits)} mm`);
const deg = (radians) => (radians == null ? "–" : `${significant((radians * 180) / Math.PI, 2)}°`);
/** A time in UTC, to the minute. */
const date = (text) => `${text.slice(0, 16).replace("T", " ")} UTC`;
const count = (number, one, many = one + "s") => `${number} ${number === 1 ? one : many}`;
function quantile(values, share) {
  const sorted = Float64Array.from(values).sort();
  return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] : null;
}

/** Factor from SI, symbol and decimals of a unit for people. */
const UNITS = data.units;

/** A table from headings and rows of cells; a heading that starts with # is of numbers. The first cell of a row names it. */
function table(headings, rows) {
  const kind = (heading) => (heading.startsWith("#") ? "number" : null);
  const head = el("tr", {}, ...headings.map((heading) => el("th", { class: kind(heading), scope: "col" }, heading.replace("#", ""))));
  const body = rows.map((cells) => el("tr", {}, ...cells.map((cell, i) => el("td", { class: kind(headings[i]) ?? (i === 0 ? "name" : null) }, cell))));
  return el("table", {}, el("thead", {}, head), el("tbody", {}, ...body));
}

/** A button that saves rows of values as a CSV file, in which no text is a formula to a spreadsheet; a list of headings and rows is asked for when it is pressed. */
function csv(file, content) {
  const cell = (value) => {
    const text = typeof value === "string" && /^[=+\-@\t\r]/.test(value) ? `'${value}` : `${value ?? ""}`;
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const button = el("button", { type: "button", class: "csv" }, `Save ${file}`);
  button.addEventListener("click", () => {
    const { headings, rows } = content();
    const text = [headings, ...rows].map((row) => row.map(cell).join(",")).join("\r\n") + "\r\n";
    const address = URL.createObjectURL(new Blob(["\ufeff", text], { type: "text/csv" }));
    el("a", { href: address, download: file }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10_000);
  });
  return el("p", { class: "save" }, button);
}

/** Signs of the three verdicts, which differ in shape as well as in colour. */
const SIGNS = {
  usable: ["M16 2a14 14 0 1 1 0 28a14 14 0 1 1 0-28z", "M9 16.5l5 5l9.5-11"],
  doubtful: ["M16 2.5l14.5 26.5h-29z", "M16 12v8.5M16 24v1.4"],
  not_usable: ["M10.2 2h11.6l8.2 8.2v11.6l-8.2 8.2h-11.6l-8.2-8.2v-11.6z", "M10.5 10.5l11 11M21.5 10.5l-11 11"],
};
function sign(state) {
  const [shape, mark] = SIGNS[state];
  return el("svg", { class: "sign", viewBox: "0 0 32 32", "aria-hidden": "true" }, el("path", { class: "shape", d: shape }), el("path", { class: "mark", d: mark }));
}

const GRAVITY = { unusable: ["not_usable", "Not usable"], doubtful: ["doubtful", "Doubtful"], caution: ["caution", "Caution"] };
/** Warnings as a list, the gravest first. */
function warningItems(warnings) {
  return warnings.map(({ severity, message, advice }) => {
    const [state, word] = GRAVITY[severity];
    return el("li", { class: state }, el("strong", {}, `${word}: `), message, el("span", {}, `→ ${advice}`));
  });
}

/** Links to the sections that are shown. */
function contents() {
  const sections = [...document.querySelectorAll("section")].filter((section) => !section.hidden);
  byId("contents").append(...sections.map((section) => el("li", {}, el("a", { href: `#${section.id}` }, section.querySelector("h2").textContent))));
}

function inputTable() {
  const made = table(["file", "SHA-256"], data.inputs.map(({ path, sha256 }) => [path, sha256]));
  made.querySelectorAll("td:last-child").forEach((cell) => cell.classList.add("hash"));
  return made;
}

// What is folded stays so on paper, where its line says how much it is, but for what is marked as short.
addEventListener("beforeprint", () => document.querySelectorAll("details.short").forEach((node) => (node.open = true)));
