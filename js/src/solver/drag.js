/** The energy of one drag (Sec. 5.1) and its minimum, which the view draws before the kernel has answered. No DOM. */
import { nearest } from "../word/cubics.js";
import { coordinates, denormalize } from "../word/axes.js";
import { Layout } from "../word/forward.js";
import { ends } from "../word/rows.js";
import { Positions } from "../word/positions.js";
import { add } from "./box.js";
import { minimise } from "./levenberg_marquardt.js";
import { constraintTerm, pin, target } from "./terms.js";
import { isArray } from "../word/decode.js";

/**
 * @typedef {import("../word/forward.js").Handle} Handle
 * @typedef {import("../word/positions.js").Point} Point
 * @typedef {Record<string, number>} Values
 * @typedef {{axes: Values | Values[], met: boolean, missing: number, point: [number, number], finished: boolean,
 *   held: {axis: number, letter: number, end: -1 | 1}[]}} Place
 *   `missing`: the largest distance to a goal, in font units; `point`: where the dragged point is; `finished`: whether the
 *   solver converged in the time that it had; `held`: axes at an end of their range
 */

/** √λ of Sec. 5.1 in ems: a drag moves an axis over its range only if it gains more than this. */
const CALM = 0.001;
/** A goal nearer than this, in font units, counts as met. */
const MET = 0.5;
const ITERATIONS = 200;
/** How near the solver comes to an edge at which glyphs change, in normalized units. */
const GAP = 1e-9;
/** Milliseconds that a solve may take while the pointer moves: the next move goes on from there. */
export const PATIENCE = 8;

export class Drag {
  #carried; #bounds; #held; #home; #press; #owners; #side; #word;

  /**
   * @param {import("../word/decode.js").Word} word
   * @param {Values | Values[]} axes at the press: user values, one object or one for each letter
   * @param {object} wishes
   * @param {Handle | null} [wishes.handle] the point that is dragged, if any
   * @param {Handle[]} [wishes.pins] held where they are at the press
   * @param {Iterable<string>} [wishes.locks] tags of axes that stay as they are
   * @param {import("./terms.js").Constraint[]} [wishes.constraints]
   * @param {[first: number, last: number]} [wishes.range] letters with equal axes, which stay equal
   */
  constructor(word, axes, { handle = null, pins = [], locks = [], constraints = [], range: [first, last] = [0, 0] }) {
    // The axis vector of each letter: that of the first one in a range.
    this.#owners = word.rows[0].order.map((_, i) => (isArray(axes) ? i - Math.min(Math.max(i - first, 0), last - first) : 0));
    const vectors = isArray(axes) ? axes.filter((_, i) => i <= first || i > last) : [axes], n = word.axes.length;
    this.#word = word;
    this.#press = axes;
    /** @type {Point[]} */
    const points = [handle ?? word.rows[0].order.length, ...pins], lines = ends(word.rows[0]);
    const sizes = constraints.map(({ kind, handles }) => -points.length + points.push(...(kind === "Width" ? lines : handles)));
    const home = new Float64Array(vectors.length * n);
    vectors.forEach((values, v) => coordinates(word, values, home.subarray(v * n, (v + 1) * n)));
    this.#home = this.x = home;
    const locked = new Set(locks);
    const bound = (/** @type {"minimum" | "maximum"} */ end) => home.map((w, i) => {
      const axis = word.axes[i % n];
      return locked.has(axis.tag) ? w : coordinates({ ...word, axes: [axis] }, { [axis.tag]: axis[end] }, new Float64Array(1))[0];
    });
    this.#bounds = { lower: bound("minimum"), upper: bound("maximum") };
    /** The points on each row of glyphs that a drag has come to. @type {Map<string, (Point | null)[]>} */
    this.#carried = new Map();
    this.#side = this.#at(home, points);
    this.#carried.set(this.#side.layout.key, points);
    const { x, y } = this.#side.positions.evaluate(home);
    this.#held = pins.map((_, i) => pin(i + 1, [x[i + 1], y[i + 1]]));
    let next = 1 + pins.length;
    constraints.forEach((constraint, i) => {
      this.#held.push(constraintTerm(constraint, Array.from({ length: sizes[i] }, () => next++)));
    });
  }

  /**
   * Points on the row of glyphs at a place, and the box around it in which the word has that row.
   * @param {Float64Array} theta @param {Point[]} points
   */
  #at(theta, points) {
    const word = this.#word, press = this.#press, home = this.#home, n = word.axes.length, layout = new Layout(word).evaluate(this.#values(theta));
    const positions = new Positions(word, layout.row, points, this.#owners), kinks = positions.kinks();
    const lower = this.#bounds.lower.slice(), upper = this.#bounds.upper.slice();
    // Where axes move others, the edges lie in other coordinates.
    if (!word.final) theta.forEach((w, i) => {
      for (const edge of word.settings.edges[i % n]) {
        if (edge < w) lower[i] = Math.max(lower[i], edge + GAP);
        else upper[i] = Math.min(upper[i], edge - GAP);
      }
    });
    return {
      layout, points, positions, home, lower, upper,
      kinks: Array.from(home, (_, i) => kinks[i % n]), pull: (CALM * word.unitsPerEm) ** 2,
    };
  }

  /**
   * The same points beyond a side of the box: on the same curve where both glyphs have the same contours, else the
   * nearest of the outline. Null where the letters are others.
   * @param {ReturnType<Drag["at"]>} side @param {Float64Array} theta
   */
  #beyond({ layout: near, points }, theta) {
    const far = new Layout(this.#word).evaluate(this.#values(theta));
    near.evaluate(this.axes);
    const carried = this.#carried.get(far.key) ?? points.map((point) => {
      // The ends of lines come after the letters.
      if (typeof point === "number") return point - near.row.order.length + far.row.order.length;
      const letter = point[0], glyph = far.glyphs[letter];
      if (String(glyph.contours) === String(near.glyphs[letter].contours)) return point;
      const [x, y] = near.position(point);
      const only = { points: [far.points[letter]], glyphs: [glyph], x: [0], y: [0], position: () => [0, 0] };
      const found = nearest(/** @type {any} */ (only), x - near.x[letter], y - near.y[letter]);
      return found && /** @type {Handle} */ ([letter, found.contour, found.segment, found.t]);
    });
    this.#carried.set(far.key, carried);
    return String(far.row.clusters) !== String(near.row.clusters) || carried.includes(null) ? null : this.#at(theta, /** @type {Handle[]} */ (carried));
  }

  /**
   * Drags the point to a place, or without one meets the constraints. Each call starts where the last one ended, and
   * prefers places near the press. Where it ends at a side of the box in which the letters have their glyphs, it goes on
   * beyond if that is better.
   * @param {[number, number] | null} place @param {number} [milliseconds] at most, by default as long as it takes
   * @returns {Place}
   */
  to(place, milliseconds) {
    const terms = place ? [target(0, place), ...this.#held] : this.#held;
    const solve = (/** @type {ReturnType<Drag["at"]>} */ side, /** @type {Float64Array} */ start) => {
      const evaluate = (/** @type {Float64Array} */ theta) => rows(terms, side.positions.evaluate(theta));
      return { side, ...minimise({ ...side, evaluate }, start, ITERATIONS, milliseconds) };
    };
    let best = solve(this.#side, this.x), from;
    // Whether a bound of the box is one of the axis, too.
    const ends = (/** @type {number} */ end, /** @type {number} */ i) => (end < 0
      ? best.side.lower[i] === this.#bounds.lower[i] : best.side.upper[i] === this.#bounds.upper[i]);
    do {
      from = best;
      this.x = best.x;
      from.active.forEach((end, i) => {
        if (!end || best !== from || ends(end, i)) return;
        const start = from.x.map((v, j) => (j === i ? v + 2 * end * GAP : v)), side = this.#beyond(from.side, start), other = side && solve(side, start);
        if (other && other.cost < best.cost) best = other;
      });
    } while (best !== from);
    const { active, side, converged: finished } = best, n = this.#word.axes.length;
    this.#side = side;
    this.cost = best.cost;
    const { x, y } = side.positions.evaluate(this.x), missing = Math.max(0, ...terms.map((term) => term.miss(term.rows(x, y).map((row) => row.value))));
    const held = Array.from(active, (end, i) => ({ axis: i % n, letter: this.#owners.indexOf(Math.floor(i / n)), end })).filter(({ end }, i) => end && ends(end, i));
    return { axes: this.axes, met: missing <= MET, missing, point: [x[0], y[0]], finished, held: /** @type {Place["held"]} */ (held) };
  }

  /** Where the next call of `to` starts: the result of the last one, or of an earlier one if this is set to it. */
  get state() {
    return { x: this.x, side: this.#side };
  }

  set state({ x, side }) {
    this.x = x;
    this.#side = side;
  }

  /** User values at the present place; an axis that has not moved keeps its value to the last digit. */
  get axes() {
    return this.#values(this.x);
  }

  /** @param {Float64Array} x */
  #values(x) {
    const word = this.#word, press = this.#press, home = this.#home, n = word.axes.length;
    const vector = (/** @type {Values} */ values, /** @type {number} */ v) => Object.fromEntries(word.axes.map((axis, i) => {
      const at = v * n + i;
      return [axis.tag, x[at] === home[at] ? values[axis.tag] ?? axis.default : denormalize(axis, x[at])];
    }));
    return isArray(press) ? press.map((values, i) => vector(values, this.#owners[i])) : vector(press, 0);
  }
}

/** Residuals of terms and their Jacobian, by the chain rule. @param {import("./terms.js").Term[]} terms @param {Positions} positions */
function rows(terms, positions) {
  /** @type {number[]} */
  const residual = [];
  /** @type {Float64Array[]} */
  const jacobian = [];
  for (const term of terms) {
    const root = Math.sqrt(term.weight);
    for (const { value, by } of term.rows(positions.x, positions.y)) {
      const row = new Float64Array(positions.size);
      for (const [point, x, y] of by) {
        if (x !== 0) add(row, root * x, positions.dx[point]);
        if (y !== 0) add(row, root * y, positions.dy[point]);
      }
      residual.push(root * value);
      jacobian.push(row);
    }
  }
  return { residual: Float64Array.from(residual), jacobian };
}
