"use strict";

// What every page's charts are made of: the colours of its style, elements, and numbers as text.

const DASH = "–";

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
let colours = {};
function readColours() {
  for (const name of ["soft", "grid", "line", "fill", "band", "edge", "alarm"]) colours[name] = colour(name);
}

function element(parent, tag, className = "", text = "") {
  const made = document.createElement(tag);
  made.className = className;
  made.textContent = text;
  parent.append(made);
  return made;
}

// As many digits as the deviation has two of.
function withDeviation(value, sd, unit) {
  if (!Number.isFinite(value)) return DASH;
  const end = unit && unit !== DASH ? " " + unit : "";
  if (!(sd > 0) || !Number.isFinite(sd)) return rounded(value) + end;
  const digits = Math.max(0, 1 - Math.floor(Math.log10(sd)));
  if (digits > 9 || Math.abs(value) > 1e7) return `${value.toExponential(4)} ± ${sd.toExponential(1)}${end}`;
  return `${value.toFixed(digits)} ± ${sd.toFixed(digits)}${end}`;
}

function rounded(value, digits = 5) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : DASH;
}

const two = (number) => String(number).padStart(2, "0");

// A time on an axis whose marks lie `step` seconds apart: seconds, or h:mm:ss, with days before; or the clock's
// time where t counts seconds since 1970.
function timeText(t, step) {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  if (t > 1e9) {
    const date = new Date(t * 1000);
    const clock = `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}`;
    return digits ? clock + (t % 1).toFixed(Math.min(digits, 6)).slice(1) : clock;
  }
  if (t < 600 || step < 1) return t.toFixed(Math.min(digits, 6));
  const days = Math.floor(t / 86400), hours = Math.floor(t / 3600) % 24;
  return `${days ? days + "d " : ""}${hours}:${two(Math.floor(t / 60) % 60)}:${two(Math.floor(t) % 60)}`;
}

const TIME_STEPS = [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120,
  300, 600, 900, 1800, 3600, 7200, 14400, 21600, 43200, 86400, 172800, 604800, 1209600, 2419200, 4838400, 9676800];
