/**
 * The forward model: axis values in, outlines of a word out (Eq. 1–3). No DOM; after construction
 * it allocates nothing, so it runs at slider rate.
 */
import { coordinates } from "./axes.js";
import { cubic } from "./cubics.js";
import { scalars } from "./regions.js";
import { chain, ends, rowAt, rowOf, valueOf } from "./rows.js";
import { evaluate } from "./varying.js";

/**
 * @typedef {import("./decode.js").Glyph} Glyph
 * @typedef {import("./decode.js").Word} Word
 * @typedef {[glyph: number, contour: number, segment: number, t: number]} Handle
 */

/** The coordinates at which the regions apply: those of avar 2 where the font has it. @param {Word} word @param {ArrayLike<number>} w */
export const final = (word, w) => (word.final ? evaluate(word.final, word.regions, w) : w);

/**
 * p(w), Eq. 1.
 * @param {Glyph} glyph @param {Float64Array} gamma @param {Float64Array} out 2k numbers
 */
export function interpolate(glyph, gamma, out) {
  const { points, regions } = glyph;
  const size = 2 * glyph.k;
  for (let i = 0; i < size; i++) out[i] = points[i];
  for (let j = 0; j < regions.length; j++) {
    const g = gamma[regions[j]];
    if (g === 0) continue;
    const o = size * (1 + j);
    for (let i = 0; i < size; i++) out[i] += g * points[o + i];
  }
  return out;
}

/** A word laid out at some axis values (Eq. 3 and what shaping adds); made once, moved as often as wanted. */
export class Layout {
  #chains;

  /** @param {Word} word */
  constructor(word) {
    this.word = word;
    /** Final coordinates, and the scalars of the regions there, for each axis vector. @type {ArrayLike<number>[]} */
    this.places = [];
    /** @type {Float64Array[]} */
    this.gammas = [];
    this.#set(word.rows[0], "");
  }

  /** Makes room for another row of glyphs. @param {import("./rows.js").Row} row @param {string} key */
  #set(row, key) {
    this.row = row;
    this.key = key;
    const count = row.anchors.length, letters = row.order.length;
    this.glyphs = row.order.map((g) => this.word.glyphs[g]);
    /** Control points of each letter, relative to its origin. @type {Float64Array[]} */
    this.points = this.glyphs.map((glyph) => new Float64Array(2 * glyph.k));
    /** Origins of the letters, then the ends of the lines. */
    this.x = new Float64Array(count);
    this.y = new Float64Array(count);
    this.advance = new Float64Array(letters);
    this.#chains = row.anchors.map((_, i) => chain(row, i));
  }

  /**
   * @param {Record<string, number> | Record<string, number>[]} axes user values, shared or per letter
   * @returns {this} whose `row` may be another one than before
   */
  evaluate(axes) {
    const { word } = this, shared = !Array.isArray(axes);
    const vectors = shared ? [axes] : word.rows[0].order.map((_, i) => axes[i] ?? {});
    const choice = vectors.map((values, v) => {
      this.gammas[v] ??= new Float64Array(word.regions.count);
      this.places[v] = final(word, coordinates(word, values, new Float64Array(word.axes.length)));
      scalars(word.regions, this.places[v], this.gammas[v]);
      return rowAt(word, this.places[v]);
    });
    const key = String(choice);
    if (key !== this.key) this.#set(rowOf(word, choice), key);
    const { row } = this;
    const gamma = (/** @type {number} */ letter) => this.gammas[shared ? 0 : letter];
    // Letters that share a glyph and their axes are copies.
    const seen = new Map();
    for (let i = 0; i < row.order.length; i++) {
      const twin = shared ? seen.get(row.order[i]) : undefined;
      if (twin === undefined) {
        const { outline } = this.glyphs[i];
        if (outline) this.points[i].set(evaluate(outline, word.regions, this.placeOf(i)));
        else interpolate(this.glyphs[i], gamma(i), this.points[i]);
        seen.set(row.order[i], i);
      } else this.points[i].set(this.points[twin]);
      this.advance[i] = Math.max(0, valueOf(this.glyphs[i].advance, gamma(i)));
    }
    for (let i = 0; i < row.anchors.length; i++) {
      let x = word.tracking * row.gaps[i], y = 0;
      for (const k of this.#chains[i]) {
        const own = row.own[k], anchored = row.anchored[k], anchor = row.anchors[k];
        const here = gamma(k < row.order.length ? k : Math.max(anchor, 0)), there = gamma(Math.max(anchor, 0));
        x += valueOf(own.x, here) + valueOf(anchored.x, there);
        y += valueOf(own.y, here) + valueOf(anchored.y, there);
      }
      for (const [letter, share] of row.pushed[i]) x += share * this.advance[letter];
      const [dx, dy] = word.offsets[i] ?? [0, 0];
      this.x[i] = x + (i < row.order.length ? dx : 0);
      this.y[i] = y + (i < row.order.length ? dy : 0);
    }
    for (let i = 0; i < row.order.length; i++) this.advance[i] *= row.bases[i];
    return this;
  }

  /** The final coordinates of a letter. @param {number} letter */
  placeOf(letter) {
    return this.places[this.places.length > 1 ? letter : 0];
  }

  /** Where each line that has letters ends. @returns {[number, number][]} */
  get ends() {
    return ends(this.row).map((i) => [this.x[i], this.y[i]]);
  }

  /** The letter whose advance is at a place, on the nearest line; −1 for none. @param {number} x @param {number} y */
  letterAt(x, y) {
    const far = (/** @type {number} */ i) => Math.abs(this.y[i] + 0.3 * this.word.unitsPerEm - y);
    return this.row.order.reduce((best, _, i) => (
      x >= this.x[i] && x < this.x[i] + this.advance[i] && !(far(i) >= far(best)) ? i : best), -1);
  }

  /** Is there such a point? @param {any} handle */
  has(handle) {
    if (!Array.isArray(handle) || handle.length < 4) return false;
    const [glyph, contour, segment, t] = handle;
    const segments = this.glyphs[glyph]?.contours[contour];
    return Number.isInteger(segment) && segment >= 0 && segment < segments && t >= 0 && t <= 1;
  }

  /** Where a handle is, in word coordinates. @param {Handle} handle @returns {[number, number]} */
  position([glyph, contour, segment, t]) {
    const { contours, starts } = this.glyphs[glyph];
    const p = this.points[glyph], start = starts[contour], size = 3 * contours[contour];
    const at = (/** @type {number} */ i) => 2 * (start + ((3 * segment + i) % size));
    const a = at(0), b = at(1), c = at(2), d = at(3);
    const x = this.x[glyph] + cubic(p[a], p[b], p[c], p[d], t);
    const y = this.y[glyph] + cubic(p[a + 1], p[b + 1], p[c + 1], p[d + 1], t);
    return [x, y];
  }

  /** Where a letter ends below: at the baseline or under it. @param {number} letter */
  bottom(letter) {
    let low = 0;
    for (let i = 1, p = this.points[letter]; i < p.length; i += 2) low = Math.min(low, p[i]);
    return this.y[letter] + low;
  }

  /** What the control points cover: [left, bottom, right, top], the ends of the lines included. */
  box() {
    let left = 0, bottom = 0, right = Math.max(0, ...this.x), top = 0;
    this.points.forEach((p, i) => {
      const x = this.x[i], y = this.y[i];
      bottom = Math.min(bottom, this.bottom(i));
      for (let j = 0; j < p.length; j += 2) {
        left = Math.min(left, x + p[j]);
        right = Math.max(right, x + p[j]);
        top = Math.max(top, y + p[j + 1]);
      }
    });
    return [left, bottom, right, top];
  }
}
