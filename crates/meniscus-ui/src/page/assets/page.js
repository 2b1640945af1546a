// The page: what came, shown; what is old, said.

import { Camera } from './camera.js';
import { drawBar, niceAbove, shortNumber } from './colours.js';
import { Connection } from './connection.js';
import { PLAIN, TECHNICAL, counters } from './counters.js';
import { FIELDS } from './field.js';
import { Liquid } from './liquid.js';
import { Past } from './past.js';
import { History, Profile } from './plots.js';

/** Without news for so long, what is shown is old. */
const OLD_MS = 500;
/** Without an image for so long, the camera is lost. */
const LOST_S = 0.25;
/** An image this much older than the turn beside it is no longer the present one. */
const IMAGE_OLD_S = 1;
/** An image this far from the frame of a paused page says so. */
const IMAGE_BESIDE_S = 0.05;
/** Time between two changes of the numbers, so that they can be read. */
const NUMBERS_MS = 250;
/** Share of a colour scale's excess that goes with each frame. */
const SCALE_FADES = 0.001;

const $ = (id) => document.getElementById(id);
const liquid = new Liquid($('gl'));
const camera = new Camera($('camera'));
const profile = new Profile($('profile'));
const energy = new History($('energy'), 8, 'mJ', ['slosh']);
const entropy = new History($('entropy'), 8, 'mJ', ['heat']);
const deadline = new History($('deadline'), 8, 'ms', ['estimated'], 16.667);
const past = new Past();
const shown = { frame: null, fresh: false, paused: false, at: -Infinity, ranges: {}, frames: 0, lost: 'Connecting.', refused: false, numbersAt: -Infinity };

$('no-gl').hidden = liquid.gl !== null;
drawBar($('bar'));
FIELDS.forEach(({ name }, k) => $('field').add(new Option(name, k)));

/** A field of a group that the model does not know cannot be chosen, and a sentence says why. */
function offerFields(model) {
  const known = FIELDS.map((field) => model.knows(field));
  [...$('field').options].forEach((option, k) => {
    option.disabled = !known[k];
    option.textContent = known[k] ? FIELDS[k].name : `${FIELDS[k].name} (not known)`;
  });
  if (!known[$('field').value]) $('field').value = known.indexOf(true);
  $('unknown').textContent = model.facts.unknown ?? '';
  $('unknown').hidden = !model.facts.unknown;
  document.body.classList.toggle('no-field', !known.includes(true));
}

/** The field that is chosen; none where the model knows none. */
const chosen = () => FIELDS[$('field').value];

const connection = new Connection({
  model(model) {
    shown.model = model;
    shown.frame = null;
    shown.ranges = {};
    liquid.take(model);
    offerFields(model);
    camera.forget();
    past.forget();
    goOn();
    for (const history of [energy, entropy, deadline]) history.forget();
    $('title').textContent = model.facts.title;
    $('size').textContent = `glass ${shortNumber(2e3 * model.facts.radius_m)} mm wide, filled to ${shortNumber(1e3 * model.facts.fill_m)} mm`;
    document.title = `meniscus: ${model.facts.liquid}`;
  },
  /** What happened to the camera; nothing when it is well again. */
  note(text) {
    $('note').textContent = text && `Camera: ${text}.`;
    $('note').hidden = !text;
  },
  frame(frame) {
    shown.at = performance.now();
    shown.lost = null;
    shown.refused = false;
    // Curves go on while the page is paused or hidden; only the eye's part waits.
    energy.push(frame.time, [1e3 * frame.slosh_j]);
    entropy.push(frame.time, [1e3 * frame.heat_j]);
    deadline.push(frame.time, [1e-3 * frame.latency_us]);
    if (shown.paused) return;
    past.frame(frame);
    shown.frame = frame;
    shown.fresh = true;
    shown.frames += 1;
  },
  image(buffer) {
    if (shown.paused) return;
    past.image(Camera.timeOf(buffer), buffer);
    camera.take(buffer).catch(() => camera.forget());
  },
  state(name, words) {
    shown.lost = words;
    shown.refused = name === 'refused';
  },
});

$('image').onchange = () => { connection.image = Number($('image').value); };
$('reset').onclick = () => liquid.reset();
// The scale of one field says nothing of another.
$('field').onchange = () => { $('top').value = ''; shown.fresh = shown.frame !== null; };
$('top').oninput = () => { shown.fresh = shown.frame !== null; };
$('rate').onchange = () => { connection.rate = Number($('rate').value); };

/** Stops the page, not the run, or lets it go on. */
function pause(paused) {
  shown.paused = paused;
  $('pause').setAttribute('aria-pressed', paused);
  $('pause').textContent = paused ? 'Go on' : 'Pause';
  $('look-back').hidden = !paused || past.frames.length < 2;
  $('back').max = past.frames.length - 1;
  $('back').value = past.frames.length - 1;
}

const goOn = () => pause(false);
$('pause').onclick = () => pause(!shown.paused);
/** One frame of the last seconds, with the image of its time. */
$('back').oninput = () => {
  const frame = past.frames[Number($('back').value)];
  shown.frame = frame;
  shown.fresh = true;
  shown.numbersAt = -Infinity;
  const image = past.imageOf(frame);
  if (image) camera.again(image).catch(() => camera.forget());
};

/** Colours reach from the least to the largest value of the last seconds, both rounded so that they hold still. */
function range(name, low, high) {
  const last = shown.ranges[name] ?? [low, high];
  const now = [Math.min(low, last[0] + SCALE_FADES * (low - last[0])), Math.max(high, last[1] + SCALE_FADES * (high - last[1]))];
  shown.ranges[name] = now;
  return [now[0] < 0 ? -niceAbove(-now[0]) : 0, niceAbove(now[1])];
}

function drawLiquid(frame) {
  const field = chosen();
  const [low, largest] = range(field?.name, ...shown.model.field(field, frame.coefficients));
  const top = Number($('top').value);
  const high = top > Math.max(low, 0) ? top : largest;
  liquid.show(low, high, frame.glass_x_m);
  if (!field) return;
  $('unit').textContent = field.unit;
  $('low').textContent = shortNumber(low);
  $('high').textContent = `${shortNumber(high)} ${field.unit}`;
  $('half').textContent = frame.mode === 'filling' ? '' : `90 % of the values are within \u00b1 ${shortNumber(field.factor * frame[field.half])} ${field.unit}`;
}

const fillCounters = [[$('counters'), PLAIN], [$('technical'), TECHNICAL]].map(([list, of]) => counters(list, of));

const STAGES = ['surface', 'predict', 'encode', 'correct', 'field'];

function drawNumbers(frame) {
  fillCounters.forEach((fill) => fill(frame));
  $('true-key').hidden = !Number.isFinite(frame.surface_error);
  $('surface-error').textContent = `error ${shortNumber(100 * frame.surface_error)} % relative to the slosh`;
  const { range: depths } = camera;
  const none = connection.image === 1 ? 'no depth image of the same lens' : '';
  $('depths').textContent = depths ? `depth: yellow ${shortNumber(1e3 * depths[0])} mm, violet ${shortNumber(1e3 * depths[1])} mm` : none;
  for (const [name, joules] of [['slosh', frame.slosh_j], ['heat', frame.heat_j]]) {
    $(name).textContent = Number.isFinite(joules) ? `${shortNumber(1e3 * joules)} mJ` : 'not known';
  }
  $('energy').classList.toggle('unknown', !Number.isFinite(frame.slosh_j));
  $('entropy').classList.toggle('unknown', !Number.isFinite(frame.heat_j));
  $('turn').textContent = `${shortNumber(1e-3 * frame.turn_us)} ms`;
  $('stages').replaceChildren(...STAGES.map((name) => {
    const [part, number] = [document.createElement('span'), document.createElement('b')];
    number.textContent = frame[`${name}_us`];
    part.append(`${name} `, number, ' \u00b5s');
    return part;
  }));
  const known = Number.isFinite(frame.crest_m) && frame.mode !== 'halted';
  $('crest').textContent = known
    ? `next crest ${shortNumber(1e3 * frame.crest_m)} \u00b1 ${shortNumber(1e3 * frame.crest_half_m)} mm in ${shortNumber(frame.crest_turns * shown.model.facts.turn_s)} s${frame.crest_spills ? ', MAY SPILL' : ''}`
    : '';
}

function pill(id, words, kind) {
  if ($(id).textContent !== words) $(id).textContent = words;
  $(id).className = `pill ${kind}`;
}

/** What a person must know before believing anything on the page. */
function warning(frame, age_s) {
  if (shown.lost !== null && age_s * 1e3 > OLD_MS) return [`${shown.lost} ${shown.refused ? '' : 'Trying again. '}${frame ? `What you see is ${shortNumber(age_s)} s old.` : ''}`, 'bad'];
  if (!frame) return ['Waiting for the first frame.', 'warn'];
  if (age_s * 1e3 > OLD_MS) return [`No news for ${shortNumber(age_s)} s: what you see is old.`, 'bad'];
  if (shown.paused) return [`Paused at ${frame.time.toFixed(2)} s of the camera's time.`, 'warn'];
  if (frame.mode === 'halted' && frame.unseen_s < LOST_S) return ['The camera is back: the window of 16 frames is filling, and there is no estimate yet.', 'warn'];
  if (frame.mode === 'halted') return ['Camera lost: nothing seen for more than a second, so no estimate is given.', 'bad'];
  if (frame.unseen_s > LOST_S) return [`Camera lost: no image for ${shortNumber(frame.unseen_s)} s. The model carries the liquid on by itself.`, 'bad'];
  if (frame.mode === 'filling') return ['The window of 16 frames is filling: there is no estimate yet.', 'warn'];
  return null;
}

/** How far the image's time is from the frame's, where that matters. */
function imageAge(frame, noImage) {
  if (!frame || !Number.isFinite(camera.time)) return '';
  const age_s = frame.time - camera.time;
  if (shown.paused && Math.abs(age_s) > IMAGE_BESIDE_S) return `${shortNumber(Math.abs(age_s))} s ${age_s > 0 ? 'earlier' : 'later'}`;
  return noImage ? `${shortNumber(age_s)} s old` : '';
}

const MODES = { tracking: 'good', filling: 'warn', coasting: 'warn', halted: 'bad' };

function draw() {
  requestAnimationFrame(draw);
  const { frame } = shown;
  const age_s = Number.isFinite(shown.at) ? (performance.now() - shown.at) / 1e3 : 1e9;
  const alert = warning(frame, age_s);
  const old = !frame || shown.paused || age_s * 1e3 > OLD_MS;
  $('banner').hidden = alert === null;
  if (alert) {
    if ($('banner').textContent !== alert[0]) $('banner').textContent = alert[0];
    $('banner').className = alert[1];
  }
  const noImage = !frame || !(frame.time - camera.time < IMAGE_OLD_S);
  document.body.classList.toggle('old', old && !shown.paused);
  document.body.classList.toggle('no-estimate', Boolean(frame) && !frame.fieldFresh);
  document.body.classList.toggle('no-image', noImage);
  $('image-age').textContent = imageAge(frame, noImage);
  pill('connection', shown.refused ? 'refused' : age_s * 1e3 <= OLD_MS ? (shown.paused ? 'paused' : 'live') : shown.lost !== null ? 'reconnecting' : 'no news', age_s * 1e3 <= OLD_MS ? (shown.paused ? 'warn' : 'good') : 'bad');
  if (frame) pill('mode', frame.mode, old ? '' : MODES[frame.mode]);
  if (shown.fresh && frame) {
    shown.fresh = false;
    // A field that was left out is not made up here: what stands stays, greyed.
    if (frame.fieldFresh) drawLiquid(frame);
    profile.draw(frame, shown.model.facts);
    if (performance.now() - shown.numbersAt > NUMBERS_MS) {
      shown.numbersAt = performance.now();
      drawNumbers(frame);
    }
  }
  if (shown.model && !shown.paused && age_s * 1e3 <= OLD_MS) {
    energy.draw();
    entropy.draw();
    deadline.draw();
  }
  liquid.draw();
  Object.assign(document.documentElement.dataset, { state: $('connection').textContent, mode: frame?.mode ?? '', frames: shown.frames, imageTime: camera.time });
}

connection.open();
requestAnimationFrame(draw);
