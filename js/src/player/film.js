/** The frames of an animation: axis values, places and rotations in time, and what lies between. No DOM. */
import { floats, isArray } from "../word/decode.js";

/**
 * @typedef {object} Film
 * @property {number[]} times seconds, from 0
 * @property {number} duration
 * @property {number} vectors how many axis vectors a frame has: one, or one for each letter
 * @property {number} letters
 * @property {Float32Array} axes user values, frames × vectors × axes
 * @property {Float32Array} offsets frames × letters × 2
 * @property {Float32Array} rotations frames × letters, counterclockwise
 * @property {number[]} box left, bottom, right and top of what is shown, in font units
 * @property {string[]} obstacles path data
 * @property {number[]} scene the index of each frame's path data
 */

/** @param {any} condition @param {string} message */
function check(condition, message) {
  if (!condition) throw new Error(message);
}

/**
 * @param {any} raw the `_film` trait @param {import("../word/decode.js").Word} word
 * @returns {Film}
 * @throws {Error} which names what is wrong
 */
export function decodeFilm(raw, word) {
  check(raw !== null && typeof raw === "object" && isArray(raw.times) && raw.times.length > 0, "there is no animation to show");
  const { times, vector_count: vectors, letter_count: letters, box, obstacles = [], scene = [] } = raw, frames = times.length;
  check(times.every((/** @type {any} */ t, /** @type {number} */ i) => Number.isFinite(t) && (i === 0 ? t === 0 : t > times[i - 1])),
    "the times do not increase");
  check(Number.isInteger(vectors) && vectors > 0 && Number.isInteger(letters) && letters > 0, "the letters are malformed");
  check(isArray(box) && box.length === 4 && box.every(Number.isFinite) && box[0] < box[2] && box[1] < box[3],
    "the box is malformed");
  check(scene.every((/** @type {any} */ i) => typeof obstacles[i] === "string"), "the obstacles are malformed");
  return {
    times, vectors, letters, box, obstacles, scene,
    duration: times[frames - 1],
    axes: floats(raw.axes, frames * vectors * word.axes.length, "axes"),
    offsets: floats(raw.offsets, frames * letters * 2, "offsets"),
    rotations: floats(raw.rotations, frames * letters, "rotations"),
  };
}

/** The last frame at or before a time. @param {Film} film @param {number} time */
export function frameAt({ times }, time) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle] <= time + 1e-9) low = middle;
    else high = middle - 1;
  }
  return low;
}

/**
 * What is shown at a time, linear between two frames.
 * @param {Film} film @param {import("../word/decode.js").Word} word @param {number} time
 */
export function stateAt(film, word, time) {
  const { times, vectors, letters, axes, offsets, rotations } = film, n = word.axes.length;
  const frame = frameAt(film, time), next = Math.min(frame + 1, times.length - 1);
  const part = next > frame ? Math.min(1, Math.max(0, (time - times[frame]) / (times[next] - times[frame]))) : 0;
  const mix = (/** @type {Float32Array} */ all, /** @type {number} */ size, /** @type {number} */ i) =>
    (1 - part) * all[frame * size + i] + part * all[next * size + i];
  const values = Array.from({ length: vectors }, (_, v) => Object.fromEntries(
    word.axes.map(({ tag }, i) => [tag, mix(axes, vectors * n, v * n + i)])));
  const each = Array.from({ length: letters }, (_, i) => i);
  return {
    frame,
    axes: vectors === 1 ? values[0] : values,
    offsets: each.map((i) => /** @type {[number, number]} */ ([mix(offsets, 2 * letters, 2 * i), mix(offsets, 2 * letters, 2 * i + 1)])),
    rotations: each.map((i) => mix(rotations, letters, i)),
  };
}

/**
 * Where a clock stands after some time: it starts again at the end, or stays there.
 * @param {number} time @param {number} duration @param {boolean} loop
 * @returns {{time: number, ended: boolean}}
 */
export function advanced(time, duration, loop) {
  if (time < duration) return { time, ended: false };
  if (!loop || duration === 0) return { time: duration, ended: true };
  return { time: time % duration, ended: false };
}

/** The axes that change. @param {Film} film @param {import("../word/decode.js").Word} word @returns {number[]} */
export function varying({ axes, times, vectors }, word) {
  const n = word.axes.length;
  return word.axes.map((_, i) => i).filter((i) => {
    for (let row = 1; row < times.length * vectors; row++) {
      if (Math.abs(axes[row * n + i] - axes[(row % vectors) * n + i]) > 1e-6) return true;
    }
    return false;
  });
}
