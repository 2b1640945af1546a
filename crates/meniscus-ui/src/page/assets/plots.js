// The curves: one plane with axes, and what is drawn on it.

import { niceAbove } from './colours.js';
import { CLOCK_ANEW_S } from './past.js';

const LEFT = 46, RIGHT = 10, TOP = 8, BOTTOM = 22;

/** A plot's canvas cleared, with axes, and its two scales; `y` and `x` are [low, high]. */
function plane(canvas, x, y, xName, yName) {
  const ratio = devicePixelRatio;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext('2d');
  const ink = getComputedStyle(canvas);
  const colour = (name) => ink.getPropertyValue(`--${name}`);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = '11px system-ui, sans-serif';
  const px = (value) => LEFT + (value - x[0]) / (x[1] - x[0]) * (width - LEFT - RIGHT);
  const py = (value) => height - BOTTOM - (value - y[0]) / (y[1] - y[0]) * (height - TOP - BOTTOM);
  pen.strokeStyle = colour('grid');
  pen.fillStyle = colour('dim');
  pen.lineWidth = 1;
  pen.textBaseline = 'middle';
  pen.textAlign = 'right';
  for (const [value, words] of ticks(y, height < 120 ? 3 : 4)) {
    pen.beginPath();
    pen.moveTo(LEFT, py(value));
    pen.lineTo(width - RIGHT, py(value));
    pen.stroke();
    pen.fillText(words, LEFT - 5, py(value));
  }
  pen.textBaseline = 'alphabetic';
  pen.textAlign = 'center';
  // The left end of the axis is its name's.
  for (const [value, words] of ticks(x, 6)) if (px(value) > LEFT + 14) pen.fillText(words, Math.min(px(value), width - RIGHT - 6), height - 7);
  pen.textAlign = 'right';
  pen.fillText(xName, LEFT - 5, height - 7);
  pen.textAlign = 'left';
  pen.fillText(yName, LEFT + 4, TOP + 8);
  pen.save();
  pen.beginPath();
  pen.rect(LEFT, 0, width - LEFT - RIGHT, height - BOTTOM);
  pen.clip();
  return { pen, px, py, colour };
}

/** Round values inside a range, about `most` of them, with the words for each. */
function ticks([low, high], most) {
  const raw = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= raw);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) values.push([k * step, (k * step).toFixed(decimals)]);
  return values;
}

function line({ pen, px, py, colour }, xs, ys, name, dash = [], width = 1.8) {
  pen.strokeStyle = colour(name);
  pen.lineWidth = width;
  pen.setLineDash(dash);
  pen.beginPath();
  let down = false;
  for (let k = 0; k < xs.length; k++) {
    if (!Number.isFinite(ys[k])) { down = false; continue; }
    if (down) pen.lineTo(px(xs[k]), py(ys[k])); else pen.moveTo(px(xs[k]), py(ys[k]));
    down = true;
  }
  pen.stroke();
  pen.setLineDash([]);
}

/** The part between value - half and value + half. */
function band({ pen, px, py, colour }, xs, ys, halves, name) {
  pen.fillStyle = colour(name);
  pen.globalAlpha = 0.16;
  pen.beginPath();
  for (let k = 0; k < xs.length; k++) pen.lineTo(px(xs[k]), py(ys[k] + halves[k]));
  for (let k = xs.length - 1; k >= 0; k--) pen.lineTo(px(xs[k]), py(ys[k] - halves[k]));
  pen.fill();
  pen.globalAlpha = 1;
}

/** Bounds of a forecast: fine dots, so that the surface stays to be seen. */
function bounds(on, xs, ys, halves, name) {
  for (const sign of [-1, 1]) line(on, xs, ys.map((z, k) => z + sign * halves[k]), name, [1, 3], 1);
}

export class Profile {
  constructor(canvas) {
    this.canvas = canvas;
    this.reach = 8;
  }

  draw(frame, { abscissae, radius_m, fill_m }) {
    const mm = (heights) => Array.from(heights, (z) => 1e3 * z);
    const xs = abscissae.map((x) => 1e3 * radius_m * x);
    const [fill, wall] = [1e3 * fill_m, 1e3 * radius_m];
    const of = Object.fromEntries(Object.entries(frame.profiles).map(([name, z]) => [name, mm(z)]));
    // The range grows at once and shrinks slowly, so that the eye has something to hold on to.
    const away = Math.max(...['estimated', 'measured'].flatMap((name) => of[name].map((z, k) => Math.abs(z - fill) + (of[`${name}_half`][k] || 0))).filter(Number.isFinite), 5);
    this.reach = Math.max(this.reach * 0.995, 1.15 * away);
    const reach = niceAbove(this.reach);
    const on = plane(this.canvas, [-wall, wall], [fill - reach, fill + reach], 'x, mm', 'z, mm');
    line(on, [-wall, wall], [fill, fill], 'dim', [2, 4]);
    if (frame.mode !== 'halted') {
      bounds(on, xs, of.ahead_1, of.ahead_1_half, 'far');
      bounds(on, xs, of.ahead_0, of.ahead_0_half, 'near');
      band(on, xs, of.estimated, of.estimated_half, 'estimated');
      line(on, xs, of.ahead_1, 'far', [5, 4]);
      line(on, xs, of.ahead_0, 'near', [5, 4]);
      line(on, xs, of.estimated, 'estimated');
    }
    line(on, xs, of.true, 'text', [2, 2], 1.2);
    const { pen, px, py, colour } = on;
    pen.fillStyle = pen.strokeStyle = colour('measured');
    pen.lineWidth = 1.2;
    of.measured.forEach((z, k) => {
      if (!Number.isFinite(z)) return;
      pen.beginPath();
      pen.moveTo(px(xs[k]), py(z - of.measured_half[k]));
      pen.lineTo(px(xs[k]), py(z + of.measured_half[k]));
      pen.stroke();
      pen.beginPath();
      pen.arc(px(xs[k]), py(z), 2.4, 0, 7);
      pen.fill();
    });
    pen.restore();
  }
}

/** Arrows at the upper edge where a curve lies above it, and the largest value in figures. */
function beyond({ pen, px, py, colour }, xs, ys, high) {
  const above = ys.map((_, k) => k).filter((k) => ys[k] > high);
  pen.fillStyle = colour('bad');
  for (const k of above) {
    pen.beginPath();
    pen.moveTo(px(xs[k]), py(high));
    pen.lineTo(px(xs[k]) - 4, py(high) + 7);
    pen.lineTo(px(xs[k]) + 4, py(high) + 7);
    pen.fill();
  }
  const largest = above.reduce((a, b) => (ys[b] > ys[a] ? b : a));
  pen.textAlign = px(xs[largest]) > px(xs[0]) + 60 ? 'right' : 'left';
  pen.fillText(ys[largest].toFixed(0), px(xs[largest]) + (pen.textAlign === 'right' ? -7 : 7), py(high) + 9);
}

/** Curves over the last seconds of the camera's time. */
export class History {
  constructor(canvas, seconds, unit, curves, limit) {
    Object.assign(this, { canvas, seconds, unit, curves, limit });
    this.forget();
  }

  forget() {
    this.times = [];
    this.values = this.curves.map(() => []);
  }

  push(time, values) {
    // A clock that began anew, or a gap, is another piece: no line joins what was never seen in between.
    const last = this.times.at(-1);
    if (time < last - CLOCK_ANEW_S) this.forget();
    else if (time > last + 0.5) { this.times.push(last + 1e-6); this.values.forEach((curve) => curve.push(NaN)); }
    this.times.push(time);
    this.values.forEach((curve, k) => curve.push(values[k]));
    const old = this.times.findIndex((t) => t >= time - this.seconds);
    if (old > 0) { this.times.splice(0, old); this.values.forEach((curve) => curve.splice(0, old)); }
  }

  draw() {
    const now = this.times.at(-1) ?? 0;
    const most = this.values.reduce((most, curve) => curve.reduce((m, v) => (v > m ? v : m), most), this.limit ?? 0);
    // A curve that stands far above zero is shown between its own ends, or one would not see it move.
    const least = this.limit ? 0 : this.values.reduce((least, curve) => curve.reduce((m, v) => (v < m ? v : m), least), most);
    const span = niceAbove(Math.max(1.05 * (most - least), 0.02 * most));
    const low = least > 2 * (most - least) ? Math.floor(least / (span / 4)) * (span / 4) : 0;
    // One value far above the limit would flatten all others for seconds: it is marked at the upper edge.
    const high = low ? low + 1.25 * span : Math.min(niceAbove(1.05 * most), 2 * (this.limit ?? Infinity));
    const on = plane(this.canvas, [-this.seconds, 0], [low, high], 's', this.unit);
    const xs = this.times.map((t) => t - now);
    if (this.limit) line(on, [-this.seconds, 0], [this.limit, this.limit], 'limit', [6, 4]);
    this.curves.forEach((name, k) => line(on, xs, this.values[k], name));
    if (most > high) beyond(on, xs, this.values[0], high);
    on.pen.restore();
  }
}
