"use strict";

// A chart of a report, as report_charts.py tells it: a caption, views to choose from, lines over an axis, and a legend
// that tells the values under the pointer. Whatever a record contains becomes text or a line, never markup.

const HEIGHT = 230;          // pixels
const COUNTS_SHARE = 0.22;   // of the height, that the fullest bar of samples takes
const SMALLEST_DRAG = 4;     // pixels, that is meant as one
const WIDTHS = { fill: 0.5, measured: 2.5 };
const MOST_RATIO = 1e5;     // of a logarithmic axis
const FONT = "11px system-ui, sans-serif";

class Chart {
  // columns: what charts share; zoomed(from, to): told when the user zooms, (null, null) to all
  constructor(figure, what, columns, zoomed) {
    this.figure = figure;
    this.what = what;
    this.columns = columns;
    this.zoomed = zoomed;
    this.span = [null, null];
    const caption = element(figure, "figcaption");
    element(caption, "span", "name", what.title);
    element(caption, "span", "about", what.about ?? "");
    this.views = element(caption, "span", "views");
    this.whole = element(caption, "button", "whole", "show all");
    this.whole.type = "button";
    this.whole.hidden = true;
    this.whole.onclick = () => this.zoomed(null, null);
    this.place = element(figure, "div");
    this.legend = element(figure, "div", "legend");
    for (const view of what.views.length > 1 ? what.views : []) this.offer(view);
    this.show(what.views[0]);
    new ResizeObserver(() => this.fit()).observe(figure);
  }

  offer(view) {
    const button = element(this.views, "button", "", view.name);
    button.type = "button";
    button.onclick = () => this.show(view);
  }

  numbers(of) {
    return typeof of === "string" ? this.columns[of] : of;
  }

  show(view) {
    this.view = view;
    for (const button of this.views.children) {
      button.setAttribute("aria-pressed", String(button.textContent === view.name));
    }
    this.plot?.destroy();
    this.tellLegend();
    const data = [this.numbers(view.at), ...(view.counts ? [view.counts] : []),
      ...view.lines.map((line) => this.numbers(line.values))];
    this.span = [null, null];
    this.whole.hidden = true;
    this.plot = new uPlot(this.options(), data, this.place);
    follow(this.plot.over);
    this.fit();
    this.tell();
  }

  options() {
    const { view } = this, first = view.counts ? 2 : 1;
    const axis = { stroke: () => colours.soft, font: FONT, labelFont: FONT, labelSize: 16, labelGap: 2,
      grid: { stroke: () => colours.grid, width: 1 }, ticks: { show: false } };
    const named = ({ name, unit }) => `${name}, ${unit}`;
    const marks = (_, values) => values.map((v) => (v === null ? "" : rounded(v, 6)));
    const mostCounts = view.counts ? Math.max(...view.counts) : 1;
    return {
      width: 300, height: HEIGHT, legend: { show: false }, padding: [8, 20, 0, 0],
      cursor: { y: false, points: { size: 5 }, drag: { x: true, y: false, setScale: false },
        sync: this.what.with ? { key: this.what.with } : undefined,
        bind: { dblclick: () => () => this.zoomed(null, null) } },
      scales: { x: { time: false, distr: view.x.log ? 3 : 1 }, y: view.y.log ? { distr: 3, range: decades } : {},
        n: { range: () => [0, mostCounts / COUNTS_SHARE] } },
      axes: [{ ...axis, label: named(view.x), size: 24 },
        { ...axis, label: named(view.y), size: 52, space: 28, values: marks }],
      series: [{},
        ...(view.counts ? [{ scale: "n", fill: () => colours.band, width: 0, points: { show: false },
          paths: uPlot.paths.bars({ size: [1, Infinity], gap: 0 }) }] : []),
        ...view.lines.map((line) => ({ stroke: () => colours[line.colour], width: WIDTHS[line.colour] ?? 1.25,
          spanGaps: false, points: { show: false } }))],
      bands: (view.bands ?? []).map(([upper, lower, name]) => ({ series: [upper + first, lower + first],
        fill: () => colours[name] })),
      hooks: {
        setSelect: [(plot) => this.selected(plot)],
        setCursor: [() => this.tell()] },
    };
  }

  selected(plot) {
    const { left, width } = plot.select;
    if (width < SMALLEST_DRAG) return;
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.zoomed(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
  }

  // From there to there; null: all.
  zoom(from, to) {
    const at = this.plot.data[0];
    this.span = [from, to];
    this.whole.hidden = from === null;
    this.plot.setScale("x", { min: from ?? at[0], max: to ?? at[at.length - 1] });
  }

  fit() {
    const width = Math.floor(this.figure.clientWidth - 20);
    if (width > 40 && this.plot && width !== this.plot.width) this.plot.setSize({ width, height: HEIGHT });
  }

  tellLegend() {
    this.legend.replaceChildren();
    const told = (kind, name, note = "", unit = "") => {
      const place = element(this.legend, "span", kind);
      if (kind) element(place, "i");
      place.append(name + " ");
      return { output: element(place, "output", "", note), note, unit };
    };
    const { x, y } = this.view;
    this.outputs = [told("", x.name, "", x.unit), ...(this.view.counts ? [told("count", "samples")] : []),
      ...this.view.lines.map((line) => told(line.colour, line.name, line.note, y.unit))];
  }

  // What is under the pointer; of all lines their notes while there is none.
  tell() {
    if (!this.plot) return;
    const at = this.plot.cursor.idx;
    const pointed = at !== null && at !== undefined;
    this.outputs.forEach(({ output, note, unit }, i) => {
      const value = pointed ? this.plot.data[i][at] : null;
      output.textContent = pointed ? `${rounded(value ?? NaN, i ? 4 : 6)} ${unit}` : note;
    });
    this.outputs[0].output.parentElement.hidden = !pointed;
  }
}

// Whole powers of ten that hold what is drawn, but no more than shows: a filter's stop band goes on for ever.
function decades(_, low, high) {
  if (!(low > 0)) return [0.1, 10];
  return [10 ** Math.floor(Math.log10(Math.max(low, high / MOST_RATIO))), 10 ** Math.ceil(Math.log10(high))];
}

// A finger does what a mouse does, while up and down goes on to scroll the page.
function follow(over) {
  const like = { pointerdown: "mousedown", pointermove: "mousemove", pointerup: "mouseup", pointercancel: "mouseup" };
  for (const [kind, mouse] of Object.entries(like)) {
    over.addEventListener(kind, (touch) => {
      if (touch.pointerType !== "touch") return;
      if (kind === "pointerdown") over.dispatchEvent(new MouseEvent("mouseenter", touch));
      over.dispatchEvent(new MouseEvent(mouse, { bubbles: true, button: 0, buttons: 1, clientX: touch.clientX,
        clientY: touch.clientY, movementX: 1 }));  // uPlot passes over a move that moves nothing
    });
  }
}
