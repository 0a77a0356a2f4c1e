/** Positions of a few outline points as functions of the axes, with their derivatives (Eq. 3). No DOM. */
import { bernstein } from "./cubics.js";
import { scalars, slopes } from "./forward.js";

/**
 * @typedef {import("./forward.js").Handle} Handle
 * @typedef {{default: number, regions: number[], deltas: ArrayLike<number>}} Form  default + Σ γ_region · delta
 */

/** Given in place of a handle: the end of the last letter's advance on the baseline. */
export const END = "end";

export class Positions {
  /**
   * @param {import("./decode.js").Word} word @param {(Handle | typeof END)[]} handles
   * @param {boolean} shared one axis vector for the word, or one for each letter
   */
  constructor(word, handles, shared) {
    this.word = word;
    this.shared = shared;
    /** How many axis vectors there are, and how many numbers all of them have. */
    this.vectors = shared ? 1 : word.order.length;
    this.size = this.vectors * word.axes.length;
    this.points = handles.map((handle) => point(word, handle));
    this.gamma = Array.from({ length: this.vectors }, () => new Float64Array(word.regions.count));
    this.slopes = Array.from({ length: this.vectors }, () => new Float64Array(word.regions.axis.length));
    this.x = new Float64Array(handles.length);
    this.y = new Float64Array(handles.length);
    /** The derivatives of x and y, one row for each point. */
    this.dx = handles.map(() => new Float64Array(this.size));
    this.dy = handles.map(() => new Float64Array(this.size));
  }

  /** @param {Float64Array} theta normalized coordinates, one axis vector after the other */
  evaluate(theta) {
    const { word, points, x, y, dx, dy } = this, n = word.axes.length;
    for (let v = 0; v < this.vectors; v++) {
      const w = theta.subarray(v * n, (v + 1) * n);
      scalars(word.regions, w, this.gamma[v]);
      slopes(word.regions, w, this.slopes[v]);
    }
    for (let p = 0; p < points.length; p++) {
      const { letter, horizontal, vertical } = points[p];
      dx[p].fill(0);
      dy[p].fill(0);
      x[p] = this.add(horizontal, letter, dx[p]);
      y[p] = this.add(vertical, letter, dy[p]);
      for (let j = 0; j < letter; j++) {
        const { advance } = word.glyphs[word.order[j]];
        // An advance is never negative, as in HarfBuzz.
        if (this.value(advance, j) > 0) x[p] += this.add(advance, j, dx[p]);
      }
    }
    return this;
  }

  /** @private @param {Form} form @param {number} letter */
  value({ default: sum, regions, deltas }, letter) {
    const gamma = this.gamma[this.shared ? 0 : letter];
    for (let j = 0; j < regions.length; j++) sum += gamma[regions[j]] * deltas[j];
    return sum;
  }

  /** The value of a form, and its derivative added to a row. @private @param {Form} form @param {number} letter @param {Float64Array} row */
  add(form, letter, row) {
    const { first, axis } = this.word.regions, vector = this.shared ? 0 : letter, start = vector * this.word.axes.length;
    for (let j = 0; j < form.regions.length; j++) {
      const region = form.regions[j];
      for (let i = first[region]; i < first[region + 1]; i++) row[start + axis[i]] += form.deltas[j] * this.slopes[vector][i];
    }
    return this.value(form, letter);
  }

  /** The normalized coordinates at which the derivatives jump, for each axis. @returns {number[][]} */
  kinks() {
    const { regions, axes, glyphs, order } = this.word, { first, axis, start, peak, end } = regions;
    const felt = new Set(this.points.flatMap(({ letter, horizontal }) => [
      ...horizontal.regions, ...order.slice(0, letter).flatMap((g) => glyphs[g].advance.regions)]));
    const kinks = axes.map(() => /** @type {Set<number>} */ (new Set()));
    for (const j of felt) {
      for (let i = first[j]; i < first[j + 1]; i++) for (const w of [start[i], peak[i], end[i]]) kinks[axis[i]].add(w);
    }
    return kinks.map((values) => [...values].sort((a, b) => a - b));
  }
}

/**
 * A point relative to its letter's pen position, as two forms.
 * @param {import("./decode.js").Word} word @param {Handle | typeof END} handle
 * @returns {{letter: number, horizontal: Form, vertical: Form}}
 */
function point(word, handle) {
  if (handle === END) {
    const nothing = { default: 0, regions: [], deltas: [] };
    return { letter: word.order.length, horizontal: nothing, vertical: nothing };
  }
  const [letter, contour, segment, t] = handle, { contours, starts, k, points, regions } = word.glyphs[word.order[letter]];
  const weights = bernstein(t);
  const layer = (/** @type {number} */ index, /** @type {number} */ coordinate) => weights.reduce((sum, weight, i) => {
    const at = starts[contour] + ((3 * segment + i) % (3 * contours[contour]));
    return sum + weight * points[2 * (index * k + at) + coordinate];
  }, 0);
  const form = (/** @type {number} */ coordinate) => ({
    default: word.offsets[letter][coordinate] + layer(0, coordinate), regions, deltas: regions.map((_, j) => layer(j + 1, coordinate)),
  });
  return { letter, horizontal: form(0), vertical: form(1) };
}
