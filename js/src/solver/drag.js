/** The energy of one drag (Sec. 5.1) and its minimum, which the view draws before the kernel has answered. No DOM. */
import { coordinates, denormalize, Layout } from "../word/forward.js";
import { END, Positions } from "../word/positions.js";
import { add } from "./box.js";
import { minimise } from "./levenberg_marquardt.js";
import { constraintTerm, pin, target } from "./terms.js";

/**
 * @typedef {import("../word/forward.js").Handle} Handle
 * @typedef {Record<string, number>} Values
 * @typedef {{axes: Values | Values[], met: boolean, missing: number, held: {axis: number, letter: number, end: -1 | 1}[]}} Place
 *   `missing`: the largest distance to a goal, in font units; `held`: axes at an end of their range
 */

/** √λ of Sec. 5.1 in ems: a drag moves an axis over its range only if it gains more than this. */
const CALM = 0.001;
/** A goal nearer than this, in font units, counts as met. */
const MET = 0.5;
const ITERATIONS = 200;
/** Milliseconds that a solve may take while the pointer moves: the next move goes on from there. */
export const PATIENCE = 8;

export class Drag {
  /**
   * @param {import("../word/decode.js").Word} word
   * @param {Values | Values[]} axes at the press: user values, one object or one for each letter
   * @param {object} wishes
   * @param {Handle | null} [wishes.handle] the point that is dragged, if any
   * @param {Handle[]} [wishes.pins] held where they are at the press
   * @param {Iterable<string>} [wishes.locks] tags of axes that stay as they are
   * @param {import("./terms.js").Constraint[]} [wishes.constraints]
   */
  constructor(word, axes, { handle = null, pins = [], locks = [], constraints = [] }) {
    const shared = !Array.isArray(axes), vectors = shared ? [axes] : axes, n = word.axes.length;
    this.word = word;
    this.press = axes;
    /** @type {(Handle | typeof END)[]} */
    const points = [handle ?? END, ...pins], firsts = constraints.map(({ kind, handles }) => points.push(...(kind === "Width" ? [END] : handles)));
    this.positions = new Positions(word, new Layout(word).evaluate(axes).row, points, shared);
    const home = new Float64Array(this.positions.size);
    vectors.forEach((values, v) => coordinates(word, values, home.subarray(v * n, (v + 1) * n)));
    this.home = this.x = home;
    const { x, y } = this.positions.evaluate(home);
    this.held = pins.map((_, i) => pin(i + 1, [x[i + 1], y[i + 1]]));
    constraints.forEach((constraint, i) => {
      const count = constraint.kind === "Width" ? 1 : constraint.handles.length;
      this.held.push(constraintTerm(constraint, firsts[i] - count));
    });
    const locked = new Set(locks), kinks = this.positions.kinks();
    const bound = (/** @type {"minimum" | "maximum"} */ end) => home.map((w, i) => {
      const axis = word.axes[i % n];
      return locked.has(axis.tag) ? w : coordinates({ ...word, axes: [axis] }, { [axis.tag]: axis[end] }, new Float64Array(1))[0];
    });
    this.problem = {
      lower: bound("minimum"), upper: bound("maximum"), kinks: Array.from(home, (_, i) => kinks[i % n]),
      pull: (CALM * word.unitsPerEm) ** 2, home,
    };
  }

  /**
   * Drags the point to a place, or without one meets the constraints. Each call starts where the last one ended, and
   * prefers places near the press.
   * @param {[number, number] | null} place @param {number} [milliseconds] at most, by default as long as it takes
   * @returns {Place}
   */
  to(place, milliseconds) {
    const terms = place ? [target(0, place), ...this.held] : this.held;
    const evaluate = (/** @type {Float64Array} */ theta) => rows(terms, this.positions.evaluate(theta));
    const { x, active, cost } = minimise({ ...this.problem, evaluate }, this.x, ITERATIONS, milliseconds);
    this.x = x;
    this.cost = cost;
    this.positions.evaluate(x);
    const missing = Math.max(0, ...terms.map((term) => term.miss(term.rows(this.positions.x, this.positions.y).map((row) => row.value))));
    const n = this.word.axes.length;
    const held = Array.from(active, (end, i) => ({ axis: i % n, letter: Math.floor(i / n), end })).filter(({ end }) => end !== 0);
    return { axes: this.axes, met: missing <= MET, missing, held: /** @type {Place["held"]} */ (held) };
  }

  /** User values at the present place; an axis that has not moved keeps its value to the last digit. */
  get axes() {
    const { word, press, home, x } = this, n = word.axes.length;
    const vector = (/** @type {Values} */ values, /** @type {number} */ v) => Object.fromEntries(word.axes.map((axis, i) => {
      const at = v * n + i;
      return [axis.tag, x[at] === home[at] ? values[axis.tag] ?? axis.default : denormalize(axis, x[at])];
    }));
    return Array.isArray(press) ? press.map(vector) : vector(press, 0);
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
