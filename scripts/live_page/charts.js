"use strict";

// One chart: a caption with the value now, or under the pointer, and lines and bands over time. What is drawn of a
// bin is said by functions of the bin; a number that is not finite leaves a gap.

const NINETY_PERCENT = 1.645;  // half-width of the interval, in standard deviations
const NINETY_NINE_PERCENT = 2.576;
const HEIGHT = { wide: 210, small: 170 };  // pixels

class Chart {
  // what: name, about, unit, size, series: [{of, colour, ...}], bands: [[upper, lower, colour]] (places in series),
  // reach(bins): [lowest, highest] to show, text(bin), logarithmic
  constructor(parent, what, view) {
    this.what = what;
    this.view = view;
    this.bins = [];
    this.reach = padded([NaN, NaN], what.logarithmic);  // a logarithm has no end at 0
    this.inSight = true;
    this.figure = element(parent, "figure");
    this.figure.dataset.name = what.name;
    const caption = element(this.figure, "figcaption");
    const title = element(caption, "span");
    element(title, "span", "name", what.name);
    element(title, "span", "what", what.about ?? "");
    this.value = element(caption, "output", "value");
    this.plot = new uPlot(this.options(), [[], ...what.series.map(() => [])], element(this.figure, "div"));
    new ResizeObserver(() => this.fit()).observe(this.figure);
    new IntersectionObserver(([entry]) => { this.inSight = entry.isIntersecting; view.changed(); }).observe(this.figure);
  }

  options() {
    const { what, view } = this;
    const axis = { stroke: () => colours.soft, font: "11px system-ui, sans-serif", labelFont: "11px system-ui, sans-serif",
      grid: { stroke: () => colours.grid, width: 1 }, ticks: { show: false }, labelSize: 16, labelGap: 2 };
    return {
      width: 300, height: HEIGHT[what.size], legend: { show: false }, padding: [6, 8, 0, 0],
      cursor: { sync: { key: "time" }, drag: { x: true, y: false, setScale: false }, y: false, points: { size: 5 },
        bind: { dblclick: () => () => view.follow() } },
      scales: { x: { time: false, range: () => view.shown() },
        y: { range: () => this.reach, distr: what.logarithmic ? 3 : 1 } },
      axes: [
        { ...axis, label: "time, s", size: 24, incrs: TIME_STEPS, space: 50,
          values: (_, marks, __, ___, step) => marks.map((t) => timeText(t, step)) },
        { ...axis, label: what.unit === DASH ? "dimensionless" : what.unit || "unit not known", size: 52, space: 28,
          values: (_, marks) => marks.map((v) => (v === null ? "" : rounded(v, 6))) }],
      series: [{}, ...what.series.map((s) => ({
        stroke: () => colours[s.colour], width: s.width ?? 1.25, dash: s.dash, spanGaps: false,
        paths: s.dots ? () => null : undefined,
        points: { show: Boolean(s.dots), size: 6, fill: () => colours[s.colour], width: 0 } }))],
      bands: (what.bands ?? []).map(([upper, lower, name]) => ({ series: [upper + 1, lower + 1],
        fill: () => colours[name] })),
      hooks: {
        setSelect: [(plot) => {
          if (plot.select.width < 4) return;
          const from = plot.posToVal(plot.select.left, "x");
          const to = plot.posToVal(plot.select.left + plot.select.width, "x");
          plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          view.zoom(from, to);
        }],
        setCursor: [() => this.tell()],
        draw: [(plot) => this.drawEvents(plot)] },
    };
  }

  fit() {
    const width = Math.floor(this.figure.clientWidth - 16);
    if (width > 40 && width !== this.plot.width) this.plot.setSize({ width, height: HEIGHT[this.what.size] });
  }

  // Bins in view, and the newest that there is.
  show(bins, newest) {
    this.bins = bins;
    this.newest = newest;
    this.tell();
    if (!this.inSight || !bins.length) return;
    const numbers = (of) => bins.map((bin) => { const v = of(bin); return Number.isFinite(v) ? v : null; });
    this.reach = padded(this.what.reach(bins), this.what.logarithmic);
    this.plot.setData([bins.map((bin) => bin[1]), ...this.what.series.map((s) => numbers(s.of))]);
  }

  tell() {
    const at = this.plot?.cursor.idx;
    const bin = at === null || at === undefined ? this.newest : this.bins[at];
    this.value.textContent = bin ? this.what.text(bin) : "";
    this.view.pointed(bin === this.newest ? null : bin);
  }

  drawEvents(plot) {
    const { ctx, bbox } = plot, ratio = devicePixelRatio;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = colours.alarm;
    ctx.lineWidth = ratio;
    ctx.textAlign = "left";
    ctx.font = `${11 * ratio}px system-ui, sans-serif`;
    for (const event of this.view.events()) {
      const x = Math.round(plot.valToPos(event.onset ?? event.t, "x", true)) + 0.5;
      if (x < bbox.left || x > bbox.left + bbox.width) continue;
      ctx.setLineDash([3 * ratio, 3 * ratio]);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      if (this.what.size === "wide") ctx.fillText(String(event.what), x + 4 * ratio, bbox.top + 11 * ratio);
    }
    ctx.restore();
  }
}

function padded([low, high], logarithmic) {
  if (!(low <= high) || !Number.isFinite(high - low)) return logarithmic ? [0.1, 10] : [-1, 1];
  if (logarithmic) return [low / 1.3, high * 1.3];
  const more = 0.08 * (high - low) || 0.05 * Math.abs(high) || 1;
  return [low - more, high + more];
}

function extremes(bins, ...of) {
  let low = Infinity, high = -Infinity;
  for (const bin of bins) {
    for (const f of of) {
      const v = f(bin);
      if (v < low && v !== -Infinity) low = v;
      if (v > high && v !== Infinity) high = v;
    }
  }
  return [low, high];
}

function innovationChart(at) {
  const low = (bin) => bin[at.innovation_min], high = (bin) => bin[at.innovation_max];
  const sd = (bin) => bin[at.innovation_sd];
  const outside = (bin) => (bin[at.rejected] > 0 ? (high(bin) > -low(bin) ? high(bin) : low(bin)) : NaN);
  return {
    name: "innovation", about: "least and largest, within ±3 sd; dots: rejected", unit: "rad/s", size: "wide",
    series: [{ of: (bin) => 3 * sd(bin), colour: "edge", width: 1 }, { of: (bin) => -3 * sd(bin), colour: "edge", width: 1 },
      { of: high, colour: "line", width: 1 }, { of: low, colour: "line", width: 1 },
      { of: outside, colour: "alarm", dots: true }],
    bands: [[0, 1, "band"], [2, 3, "fill"]],
    reach: (bins) => {
      const [least, greatest] = extremes(bins, low, high), edge = 3 * sd(bins[bins.length - 1]);
      return [Math.min(least, -edge), Math.max(greatest, edge)];
    },
    text: (bin) => `${rounded(low(bin), 3)} … ${rounded(high(bin), 3)}, sd ${rounded(sd(bin), 3)} rad/s`,
  };
}

// The mean NIS of n rows is chi-square of n degrees over n where model and noise are right: Wilson and Hilferty 1931.
function chiSquareOver(n, deviations) {
  const v = 2 / (9 * n);
  return Math.max(1 - v + deviations * Math.sqrt(v), 0.05) ** 3;
}

function nisChart(at) {
  const nis = (bin) => Math.max(bin[at.nis], 1e-3), count = (bin) => Math.max(bin[at.rows] - bin[at.missing], 1);
  const bound = (sign) => (bin) => chiSquareOver(count(bin), sign * NINETY_NINE_PERCENT);
  return {
    name: "NIS", about: "mean of each bin, 99 % band of chi-square", unit: "NIS", size: "wide", logarithmic: true,
    series: [{ of: bound(1), colour: "edge", width: 1 }, { of: bound(-1), colour: "edge", width: 1 },
      { of: nis, colour: "line" }],
    bands: [[0, 1, "band"]],
    reach: (bins) => {
      const [low, high] = extremes(bins, nis);
      return [Math.max(Math.min(low, 0.3), 0.01), Math.max(high, 3)];
    },
    text: (bin) => rounded(bin[at.nis], 4),
  };
}

function parameterChart(name, unit, at) {
  const value = (bin) => bin[at[name]], sd = (bin) => bin[at[name + "_sd"]];
  const upper = (bin) => value(bin) + NINETY_PERCENT * sd(bin), lower = (bin) => value(bin) - NINETY_PERCENT * sd(bin);
  return {
    name, unit, size: "small",
    series: [{ of: upper, colour: "fill", width: 0.5 }, { of: lower, colour: "fill", width: 0.5 },
      { of: value, colour: "line", width: 1.75 }],
    bands: [[0, 1, "fill"]],
    // The band at the end fits in; at the start of an estimate it may be too wide for anything to be seen beside it.
    reach: (bins) => {
      const [low, high] = extremes(bins, value), end = bins[bins.length - 1];
      return [Math.min(low, lower(end)), Math.max(high, upper(end))];
    },
    text: (bin) => withDeviation(value(bin), sd(bin), unit),
  };
}

function stateChart(name, unit, at) {
  const low = (bin) => bin[at[name + "_min"]], high = (bin) => bin[at[name + "_max"]];
  return {
    name, unit, size: "small",
    series: [{ of: high, colour: "line", width: 1 }, { of: low, colour: "line", width: 1 }],
    bands: [[0, 1, "fill"]],
    reach: (bins) => extremes(bins, low, high),
    text: (bin) => withDeviation(bin[at[name]], bin[at[name + "_sd"]], unit),
  };
}
