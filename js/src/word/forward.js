/**
 * The forward model: axis values in, outlines of a word out (Eq. 1–3). No DOM; after construction
 * it allocates nothing, so it runs at slider rate.
 */
import { cubic } from "./cubics.js";
import { chain, rowAt, rowOf, valueOf } from "./rows.js";
import { evaluate } from "./varying.js";
import { isArray } from "./decode.js";

/**
 * @typedef {{count: number, first: Int32Array, axis: Int32Array, start: Float64Array,
 *   peak: Float64Array, end: Float64Array}} Regions  the supports, only the axes that matter:
 *   region j owns entries first[j] … first[j + 1] − 1
 * @typedef {import("./decode.js").Axis} Axis
 * @typedef {import("./decode.js").Glyph} Glyph
 * @typedef {import("./decode.js").Word} Word
 * @typedef {[glyph: number, contour: number, segment: number, t: number]} Handle
 */

/**
 * A user value to a normalized coordinate: the default-relative scale, then the segment map.
 * @param {Pick<Axis, "minimum" | "default" | "maximum" | "map">} axis @param {number} user
 */
export function normalize(axis, user) {
  const { minimum, default: normal, maximum, map } = axis;
  const v = Math.min(Math.max(user, minimum), maximum);
  // A side of length zero is never divided by: no clamped value lies on it.
  const w = v < normal ? (v - normal) / (normal - minimum) : v > normal ? (v - normal) / (maximum - normal) : 0;
  const last = map.length - 1;
  if (last < 0) return w;
  if (w <= map[0][0]) return w - map[0][0] + map[0][1];
  for (let i = 1; i <= last; i++) {
    const [from, to] = map[i];
    if (w === from) return to;
    if (w < from) {
      const [from0, to0] = map[i - 1];
      return to0 + ((w - from0) / (from - from0)) * (to - to0);
    }
  }
  return w - map[last][0] + map[last][1];
}

/**
 * A normalized coordinate to a user value, the inverse of `normalize`. Where the segment map is flat, several
 * user values share one coordinate; the one nearest to the default is given.
 * @param {Pick<Axis, "minimum" | "default" | "maximum" | "map">} axis @param {number} w
 */
export function denormalize(axis, w) {
  const { minimum, default: normal, maximum } = axis;
  const home = normalize(axis, normal);
  if (w === home) return normal;
  const end = w > home ? maximum : minimum;
  const rises = Math.sign(w - home);
  // The corners of the map between the default and that end, from the default outwards.
  const corners = [normal, ...axis.map.map(([from]) => normal + Math.abs(from) * (end - normal))
    .filter((_, i) => Math.sign(axis.map[i][0]) === Math.sign(end - normal)), end]
    .sort((a, b) => Math.sign(end - normal) * (a - b));
  for (let i = 1; i < corners.length; i++) {
    const near = normalize(axis, corners[i - 1]), far = normalize(axis, corners[i]);
    if (rises * (far - w) >= 0 && far !== near) return corners[i - 1] + ((w - near) / (far - near)) * (corners[i] - corners[i - 1]);
  }
  return end;
}

/**
 * Keeps of each support what can differ from 1: OpenType makes an axis neutral where its peak is 0,
 * where start, peak, end are out of order, and where they straddle 0.
 * @param {ArrayLike<number>} data regions × axes × (start, peak, end)
 * @param {number} count @param {number} n number of axes
 * @returns {Regions}
 */
export function compile(data, count, n) {
  const first = new Int32Array(count + 1);
  const axis = [], start = [], peak = [], end = [];
  for (let j = 0; j < count; j++) {
    for (let i = 0; i < n; i++) {
      const o = 3 * (j * n + i);
      const s = data[o], p = data[o + 1], e = data[o + 2];
      if (p === 0 || s > p || p > e || (s < 0 && e > 0)) continue;
      axis.push(i);
      start.push(s);
      peak.push(p);
      end.push(e);
    }
    first[j + 1] = axis.length;
  }
  return {
    count, first, axis: Int32Array.from(axis),
    start: Float64Array.from(start), peak: Float64Array.from(peak), end: Float64Array.from(end),
  };
}

/** Within this of its peak a scalar is 1, even where the peak is also the start or the end. */
const ON_PEAK = 1e-9;

/** φ(v), the height of one support. @param {number} v @param {number} start @param {number} peak @param {number} end */
function height(v, start, peak, end) {
  if (Math.abs(v - peak) <= ON_PEAK) return 1;
  if (v <= start || v >= end) return 0;
  return v < peak ? (v - start) / (peak - start) : (end - v) / (end - peak);
}

/**
 * γ(w) of one region, Eq. 2: how much of its delta set applies.
 * @param {Regions} regions @param {number} j @param {ArrayLike<number>} w normalized
 */
export function scalar({ first, axis, start, peak, end }, j, w) {
  let product = 1;
  for (let i = first[j]; i < first[j + 1] && product !== 0; i++) product *= height(w[axis[i]], start[i], peak[i], end[i]);
  return product;
}

/** γ(w) of all regions. @param {Regions} regions @param {ArrayLike<number>} w normalized @param {Float64Array} out count */
export function scalars(regions, w, out) {
  for (let j = 0; j < regions.count; j++) out[j] = scalar(regions, j, w);
  return out;
}

/** The coordinates at which the regions apply: those of avar 2 where the font has it. @param {Word} word @param {ArrayLike<number>} w */
export const final = (word, w) => (word.final ? evaluate(word.final, word.regions, w) : w);

/**
 * The derivative of γ(w), one number for each entry of the supports: entry i of region j holds ∂γ_j by
 * axis[i]. At a kink it is the derivative from the right.
 * @param {Regions} regions @param {ArrayLike<number>} w normalized @param {Float64Array} out as many as entries
 */
export function slopes(regions, w, out) {
  const { count, first, axis, start, peak, end } = regions;
  for (let j = 0; j < count; j++) {
    for (let i = first[j]; i < first[j + 1]; i++) {
      const v = w[axis[i]];
      let product = v < start[i] || v >= end[i] ? 0 : v < peak[i] ? 1 / (peak[i] - start[i]) : -1 / (end[i] - peak[i]);
      for (let k = first[j]; k < first[j + 1] && product !== 0; k++) {
        if (k !== i) product *= height(w[axis[k]], start[k], peak[k], end[k]);
      }
      out[i] = product;
    }
  }
  return out;
}

/** A word's normalized coordinates. @param {Word} word @param {Record<string, number>} axes user values @param {Float64Array} w */
export function coordinates(word, axes, w) {
  for (let i = 0; i < w.length; i++) w[i] = normalize(word.axes[i], axes[word.axes[i].tag] ?? word.axes[i].default);
  return w;
}

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
    const { word } = this, shared = !isArray(axes);
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

  /** Where the first line ends. */
  get end() {
    return this.x[this.glyphs.length] ?? 0;
  }

  /** Is there such a point? @param {any} handle */
  has(handle) {
    if (!isArray(handle) || handle.length < 4) return false;
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
