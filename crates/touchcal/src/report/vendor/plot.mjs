// What charts.js uses of Observable Plot.
export { axisX, axisY, cell, dot, line, link, plot, rectY, ruleX, ruleY, text, tip, pointer } from "@observablehq/plot";
