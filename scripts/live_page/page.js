"use strict";

// Takes what the server sends, ten times a second, and shows it. Whatever comes from a stream becomes text or a
// line, never markup.

const WINDOWS = [[10, "10 s"], [60, "1 min"], [600, "10 min"], [3600, "1 h"], [Infinity, "all"]];
const FEWEST_S = 1;       // shown at the start
const MOST_EVENTS = 1000;
const RETRY_MS = 1000;
const SLOWEST_MS = 300;   // between two drawings: the page is to be half a second behind at most
const SHARE = 5;          // of the time, that drawing may take: one fifth

const byId = (id) => document.getElementById(id);

class View {
  constructor() {
    this.history = null;
    this.charts = [];
    this.allEvents = [];
    this.arm = "";
    this.window = 60;
    this.fixed = null;    // [from, to] that the user zoomed to
    this.held = null;     // bins, while paused
    this.bins = [];
    this.due = false;
    this.drawn = { at: 0, took: 0 };
  }

  lay(layout) {
    const { at } = this.history = new History(layout);
    this.bins = [];
    for (const chart of this.charts) chart.plot.destroy();
    for (const id of ["innovations", "parameters", "states"]) byId(id).replaceChildren();
    const chart = (id, what) => this.charts.push(new Chart(byId(id), what, this));
    this.charts = [];
    chart("innovations", innovationChart(at));
    chart("innovations", nisChart(at));
    for (const name of layout.parameters) chart("parameters", parameterChart(name, layout.units[name], at));
    for (const name of layout.states) chart("states", stateChart(name, layout.units[name], at));
    byId("parameters").parentElement.hidden = !layout.parameters.length;
  }

  // The stretch of time on the charts.
  shown() {
    if (this.fixed) return this.fixed;
    if (!this.bins.length) return [0, FEWEST_S];
    const first = this.bins[0][1], to = this.bins[this.bins.length - 1][1];
    return [Math.max(first, to - this.window), Math.max(to, first + FEWEST_S)];
  }

  // Those of the arm that is shown, the last word on each.
  events() {
    const ours = this.allEvents.filter((event) => !event.arm || String(event.arm) === this.arm);
    return ours.filter((event, i) => !(i + 1 < ours.length && ours[i + 1].settled && ours[i + 1].what === event.what));
  }

  zoom(from, to) {
    this.fixed = [from, to];
    this.changed();
  }

  follow(window = this.window) {
    this.window = window;
    this.fixed = null;
    this.changed();
  }

  pause(paused) {
    this.held = paused ? this.history?.all() ?? [] : null;
    byId("pause").setAttribute("aria-pressed", String(paused));
    byId("pause").textContent = paused ? "Go on" : "Pause";
    this.changed();
  }

  // Draws soon, and not so often that drawing takes more than its share.
  changed() {
    if (this.due) return;
    this.due = true;
    const rest = Math.min(this.drawn.took * SHARE, SLOWEST_MS) - (performance.now() - this.drawn.at);
    setTimeout(() => requestAnimationFrame(() => this.draw()), Math.max(rest, 0));
  }

  draw() {
    this.due = false;
    if (!this.history) return;
    const begin = performance.now();
    this.bins = this.held ?? this.history.all();
    const bins = within(this.bins, ...this.shown()), newest = this.bins[this.bins.length - 1];
    for (const chart of this.charts) {
      const known = !(chart.what.name in this.history.layout.units) || !newest ||
        Number.isFinite(newest[this.history.at[chart.what.name]]);
      chart.figure.hidden = !known;  // what only other arms' models have
      if (known) chart.show(bins, newest);
    }
    this.pointed(null);
    this.tellView();
    this.drawn = { at: performance.now(), took: performance.now() - begin };
  }

  pointed(bin) {
    const shown = bin ?? this.bins[this.bins.length - 1];
    byId("time-name").textContent = bin ? "pointing at" : "t";
    byId("time").textContent = shown ? timeWithUnit(shown[1]) : DASH;
  }

  tellView() {
    for (const button of byId("windows").children) {
      button.setAttribute("aria-pressed", String(!this.fixed && Number(button.value) === this.window));
    }
    byId("zoomed").hidden = !this.fixed;
    const [from, to] = (this.fixed ?? [0, 0]).map((t) => rounded(t, 7));
    byId("zoomed").textContent = `${from} to ${to} s; double-click to go on`;
  }
}

function timeWithUnit(t) {
  return t < 600 ? t.toFixed(2) + " s" : timeText(t, 1);
}

function tellState(state, text) {
  byId("state").dataset.state = state;
  byId("state").textContent = text;
}

function tellCounts({ counts, malformed }) {
  const [rows, ...others] = counts;
  const names = ["missing", "rejected", "gaps", "resets"];
  const parts = others.map((count, i) => [count, names[i]]).concat([[malformed, "unreadable"]]);
  const told = parts.filter(([count]) => count > 0).map(([count, name]) => `${count.toLocaleString("en")} ${name}`);
  byId("counts").textContent = [`${rows.toLocaleString("en")} rows`, ...told].join(" · ");
}

function cell(row, text, className = "") {
  return element(row, "td", className, text);
}

function tellEvents(events) {
  const body = document.querySelector("#events tbody");
  for (const event of events) {
    const row = document.createElement("tr");
    cell(row, rounded(event.onset, 7));
    cell(row, rounded(event.t, 7));
    cell(row, event.arm ?? "", "arm text");
    cell(row, event.what ?? DASH, "text");
    for (const key of ["from", "to"]) cell(row, rounded(event[key]));
    cell(row, rounded(event.sd, 2));
    cell(row, rounded(event.p, 3));
    cell(row, [event.also_possible ?? []].flat().join(", "), "text");
    cell(row, event.settled ? "yes" : "not yet", "text");
    body.prepend(row);
  }
  while (body.rows.length > MOST_EVENTS) body.lastChild.remove();
  byId("no-events").hidden = body.rows.length > 0;
  document.querySelector("#events table").hidden = body.rows.length === 0;
}

function tellArms(table, chosen) {
  const body = document.querySelector("#arms tbody");
  document.body.classList.add("many");
  while (body.rows.length > table.length) body.lastChild.remove();
  while (body.rows.length < table.length) {
    const row = element(body, "tr");
    element(cell(row, ""), "a");
    for (let i = 0; i < 5; ++i) cell(row, "");
  }
  table.forEach((arm, i) => {
    const row = body.rows[i], link = row.firstChild.firstChild;
    if (arm.arm === chosen) row.setAttribute("aria-current", "true");
    else row.removeAttribute("aria-current");
    link.textContent = arm.arm;
    link.href = "#" + encodeURIComponent(arm.arm);
    const texts = [rounded(arm.nis ?? NaN, 3), rounded(arm.peak ?? NaN, 3), rounded(arm.lost, 2), arm.change ?? "",
      arm.silent === null ? "" : arm.silent.toFixed(0)];
    texts.forEach((text, k) => { row.cells[k + 1].textContent = text; });
    row.cells[4].className = "text";
    row.cells[5].className = "alarm";
  });
}

const view = new View();
let chosen = decodeURIComponent(location.hash.slice(1));
let socket = null;

function take(text) {
  if (text.arm !== undefined && text.arm !== view.arm) {
    view.arm = text.arm;
    byId("title").textContent = text.arm || "armukf";
    document.title = text.arm ? `${text.arm} – armukf live` : "armukf live";
  }
  if (text.layout) view.lay(text.layout);
  if (text.events) {
    view.allEvents = view.allEvents.concat(text.events).slice(-MOST_EVENTS);
    tellEvents(text.events);
  }
  if (text.table) tellArms(text.table, view.arm);
  if (text.counts) tellCounts(text);
  if (text.ended) tellState("ended", "stream ended");
  else if (text.counts) tellState("live", "live");
  else tellState("waiting", "waiting for rows");
}

function connect() {
  socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/stream`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => {
    view.allEvents = [];
    document.querySelector("#events tbody").replaceChildren();
    tellEvents([]);
    if (chosen) socket.send(chosen);
  };
  socket.onmessage = ({ data }) => {
    if (typeof data === "string") return take(JSON.parse(data));
    view.history.take(new Float64Array(data));
    if (!view.held) view.changed();
  };
  socket.onclose = () => {
    tellState("lost", "no connection, trying again");
    setTimeout(connect, RETRY_MS);
  };
}

function begin() {
  readColours();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    readColours();
    for (const chart of view.charts) chart.plot.redraw();
  });
  for (const [seconds, name] of WINDOWS) {
    const button = element(byId("windows"), "button", "", name);
    button.type = "button";
    button.value = seconds;
    button.onclick = () => view.follow(seconds);
  }
  byId("pause").onclick = () => view.pause(!view.held);
  addEventListener("keydown", (press) => {
    if (press.key !== " " || press.target instanceof HTMLButtonElement) return;
    press.preventDefault();
    view.pause(!view.held);
  });
  addEventListener("hashchange", () => {
    chosen = decodeURIComponent(location.hash.slice(1));
    view.pause(false);
    if (socket.readyState === WebSocket.OPEN) socket.send(chosen);
  });
  connect();
}

begin();
