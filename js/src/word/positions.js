/** Positions of a few outline points as functions of the axes, with their derivatives (Eq. 3). No DOM. */
import { bernstein } from "./cubics.js";
import { final } from "./forward.js";
import { scalars, slopes } from "./regions.js";
import { chain, valueOf } from "./rows.js";
import { evaluate } from "./varying.js";

/**
 * @typedef {import("./forward.js").Handle} Handle
 * @typedef {import("./rows.js").Form} Form
 * @typedef {Handle | number} Point  a point of an outline, or the entry of a row that is the end of a line
 * @typedef {{letter: number, share: number, x: Form | null, y: Form | null}} Part  a form by the scalars of a letter
 */

/** Step of a difference quotient, shorter than any distance that the solver keeps from a kink. */
const STEP = 1e-9;

export class Positions {
  #gamma; #slopes; #affine; #owners; #vectors; #points; #word;

  /**
   * @param {import("./decode.js").Word} word
   * @param {import("./rows.js").Row} row the row of glyphs that the handles are on
   * @param {Point[]} handles
   * @param {number[]} owners the axis vector of each letter
   */
  constructor(word, row, handles, owners) {
    this.#word = word;
    this.#owners = owners;
    /** How many axis vectors there are, and how many numbers all of them have. */
    this.#vectors = Math.max(...owners) + 1;
    this.size = this.#vectors * word.axes.length;
    this.#points = handles.map((handle) => point(word, row, handle));
    this.#affine = !word.final && this.#points.every(({ outline }) => !outline);
    this.#gamma = Array.from({ length: this.#vectors }, () => new Float64Array(word.regions.count));
    this.#slopes = Array.from({ length: this.#vectors }, () => new Float64Array(word.regions.axis.length));
    this.x = new Float64Array(handles.length);
    this.y = new Float64Array(handles.length);
    /** The derivatives of x and y, one row for each point. */
    this.dx = handles.map(() => new Float64Array(this.size));
    this.dy = handles.map(() => new Float64Array(this.size));
  }

  /** @param {Float64Array} theta normalized coordinates, one axis vector after the other */
  evaluate(theta) {
    const { x, y, dx, dy } = this;
    // Where the points are not affine in the scalars at theta, difference quotients take the place of the slopes.
    const columns = this.#affine ? [] : Array.from(theta, (w, i) => {
      const step = w + STEP > 1 ? -STEP : STEP;
      this.#set(theta.map((v, j) => (j === i ? v + step : v)));
      return { x: x.slice(), y: y.slice(), step };
    });
    this.#set(theta);
    columns.forEach((moved, i) => x.forEach((_, p) => {
      dx[p][i] = (moved.x[p] - x[p]) / moved.step;
      dy[p][i] = (moved.y[p] - y[p]) / moved.step;
    }));
    return this;
  }

  /** Positions and slopes. @param {Float64Array} theta */
  #set(theta) {
    const { x, y, dx, dy } = this, word = this.#word, points = this.#points, n = word.axes.length;
    /** @type {ArrayLike<number>[]} */
    const places = [];
    for (let v = 0; v < this.#vectors; v++) {
      const w = places[v] = final(word, theta.subarray(v * n, (v + 1) * n));
      scalars(word.regions, w, this.#gamma[v]);
      slopes(word.regions, w, this.#slopes[v]);
    }
    points.forEach(({ constant, parts, advances, outline, weights, letter }, p) => {
      dx[p].fill(0);
      dy[p].fill(0);
      [x[p], y[p]] = constant;
      for (const part of parts) {
        if (part.x) x[p] += this.#add(part.x, part, dx[p]);
        if (part.y) y[p] += this.#add(part.y, part, dy[p]);
      }
      for (const part of advances) {
        // An advance is never negative, as in HarfBuzz.
        if (part.x && valueOf(part.x, this.#scalarsOf(part.letter)) > 0) x[p] += this.#add(part.x, part, dx[p]);
      }
      const control = outline ? evaluate(outline, word.regions, places[this.#owners[letter]]) : [];
      for (const [at, weight] of outline ? weights : []) {
        x[p] += weight * control[2 * at];
        y[p] += weight * control[2 * at + 1];
      }
    });
  }

  /** @param {number} letter */
  #scalarsOf(letter) {
    return this.#gamma[this.#owners[letter]];
  }

  /** The value of a form, and its derivative added to a row. @param {Form} form @param {Part} part @param {Float64Array} row */
  #add(form, { letter, share }, row) {
    const { first, axis } = this.#word.regions, vector = this.#owners[letter], start = vector * this.#word.axes.length;
    for (let j = 0; j < form.regions.length; j++) {
      const region = form.regions[j];
      for (let i = first[region]; i < first[region + 1]; i++) {
        row[start + axis[i]] += share * form.deltas[j] * this.#slopes[vector][i];
      }
    }
    return share * valueOf(form, this.#gamma[vector]);
  }

  /** The normalized coordinates at which the derivatives jump, for each axis. @returns {number[][]} */
  kinks() {
    if (this.#word.kinks) return this.#word.kinks;
    const { regions, axes } = this.#word, { first, axis, start, peak, end } = regions;
    const used = new Set(this.#points.flatMap(({ parts, advances }) =>
      [...parts, ...advances].flatMap((part) => [part.x, part.y].flatMap((form) => form?.regions ?? []))));
    const kinks = axes.map(() => /** @type {Set<number>} */ (new Set()));
    for (const j of used) {
      for (let i = first[j]; i < first[j + 1]; i++) for (const w of [start[i], peak[i], end[i]]) kinks[axis[i]].add(w);
    }
    return kinks.map((values) => [...values].sort((a, b) => a - b));
  }
}

/**
 * A point as a sum of forms: its place in the letter, the steps that lead to the letter, and the advances before it.
 * @param {import("./decode.js").Word} word @param {import("./rows.js").Row} row @param {Point} handle
 * @returns {{constant: [number, number], parts: Part[], advances: Part[], outline?: any,
 *   weights: number[][], letter: number}}
 */
function point(word, row, handle) {
  const ending = typeof handle === "number", letter = ending ? handle : handle[0], last = (/** @type {number} */ i) => Math.max(row.anchors[i], 0);
  const parts = chain(row, letter).flatMap((k) => [
    { letter: k < row.order.length ? k : last(k), share: 1, ...row.own[k] },
    { letter: last(k), share: 1, ...row.anchored[k] },
  ]);
  const advances = row.pushed[letter].map(([i, share]) =>
    ({ letter: i, share, x: word.glyphs[row.order[i]].advance, y: null }));
  const [dx, dy] = (ending ? null : word.offsets[letter]) ?? [0, 0], glyph = word.glyphs[row.order[letter]];
  const weights = ending ? [] : blend(glyph, handle);
  if (!ending && !glyph.outline) parts.push({ letter, share: 1, ...within(glyph, weights) });
  return { constant: [dx + word.tracking * row.gaps[letter], dy], parts, advances, outline: glyph?.outline, weights, letter };
}

/** The control points that a point on a curve is a blend of, and their weights. @param {import("./decode.js").Glyph} glyph @param {Handle} handle */
export const blend = ({ contours, starts }, [, contour, segment, t]) =>
  bernstein(t).map((weight, i) => [starts[contour] + ((3 * segment + i) % (3 * contours[contour])), weight]);

/** A point relative to the origin of its letter. @param {import("./decode.js").Glyph} glyph @param {number[][]} weights */
export function within({ k, points, regions }, weights) {
  const layer = (/** @type {number} */ index, /** @type {number} */ coordinate) =>
    weights.reduce((sum, [at, weight]) => sum + weight * points[2 * (index * k + at) + coordinate], 0);
  const form = (/** @type {number} */ coordinate) =>
    ({ default: layer(0, coordinate), regions, deltas: regions.map((_, j) => layer(j + 1, coordinate)) });
  return { x: form(0), y: form(1) };
}
