"use strict";

// Puts the charts where the page has places for them.

const content = JSON.parse(document.getElementById("content").textContent);
const charts = [];

function readReportColours() {
  readColours();
  for (const name of ["before", "after", "measured"]) colours[name] = colour(name);
}

function redraw() {
  readReportColours();
  for (const chart of charts) chart.plot.redraw(false);
}

// Charts of the same group show the same stretch.
function zoomTogether(of, from, to) {
  for (const chart of charts) {
    if (chart === of || (of.what.with && chart.what.with === of.what.with)) chart.zoom(from, to);
  }
}

function drawAll() {
  readReportColours();
  for (const what of content.charts) {
    const chart = new Chart(document.getElementById("chart-" + what.id), what, content.columns,
      (from, to) => zoomTogether(chart, from, to));
    charts.push(chart);
  }
}

// Paper is white, and nothing can be opened on it.
function prepareForPaper() {
  for (const part of document.querySelectorAll("details")) part.open = true;
  redraw();
}

drawAll();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
addEventListener("beforeprint", prepareForPaper);
addEventListener("afterprint", redraw);
