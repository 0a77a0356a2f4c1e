/**
 * The terms of an energy over outline points, as in `vfwidget.energy`. Each gives rows: a residual, its derivative by
 * the points as [point, by x, by y], and its weight.
 */

/**
 * @typedef {{value: number, by: [point: number, x: number, y: number][]}} Row
 * @typedef {{weight: number, rows: (x: Float64Array, y: Float64Array) => Row[], miss: (values: number[]) => number}} Term
 *   `miss`: how far the goal is missed, in font units, from the values of the rows
 */

/** Pins outweigh targets: a target that is out of reach must not drag the pins along. */
const PIN_WEIGHT = 1e5;

/** Pulls a point to a place. @param {number} point @param {[number, number]} place @param {number} [weight] @returns {Term} */
export const target = (point, place, weight = 1) => ({
  weight,
  rows: (x, y) => [{ value: x[point] - place[0], by: [[point, 1, 0]] }, { value: y[point] - place[1], by: [[point, 0, 1]] }],
  miss: ([dx, dy]) => Math.hypot(dx, dy),
});

/** Holds a point at a place. @param {number} point @param {[number, number]} place */
export const pin = (point, place) => target(point, place, PIN_WEIGHT);

/**
 * Keeps points on one vertical line (coordinate 0) or one horizontal line (coordinate 1), wherever it is.
 * @param {number[]} points @param {0 | 1} coordinate @returns {Term}
 */
const aligned = (points, coordinate) => ({
  weight: PIN_WEIGHT,
  rows: (x, y) => {
    const along = points.map((point) => (coordinate ? y : x)[point]), mean = along.reduce((a, b) => a + b) / along.length;
    return points.map((_, i) => ({
      value: along[i] - mean,
      by: points.map((point, j) => {
        const part = (i === j ? 1 : 0) - 1 / points.length;
        return /** @type {[number, number, number]} */ (coordinate ? [point, 0, part] : [point, part, 0]);
      }),
    }));
  },
  miss: (values) => Math.max(...values) - Math.min(...values),
});

/** Keeps points on the straight line through the first and the last. @param {number[]} points @returns {Term} */
const collinear = (points) => ({
  weight: PIN_WEIGHT,
  rows: (x, y) => {
    const [first, ...rest] = points, last = /** @type {number} */ (rest.pop());
    const dx = x[last] - x[first], dy = y[last] - y[first], length = Math.hypot(dx, dy) || 1, [nx, ny] = [-dy / length, dx / length];
    return rest.map((point) => {
      const ox = x[point] - x[first], oy = y[point] - y[first];
      // Turning the line about its start by the last point's move across it.
      const turn = (ox * dx + oy * dy) / length ** 2;
      return {
        value: ox * nx + oy * ny,
        by: [[point, nx, ny], [last, -turn * nx, -turn * ny], [first, (turn - 1) * nx, (turn - 1) * ny]],
      };
    });
  },
  miss: (values) => Math.max(...values.map(Math.abs)),
});

/** Keeps two points at a distance. @param {number[]} points @param {number} length @returns {Term} */
const distance = ([first, second], length) => ({
  weight: PIN_WEIGHT,
  rows: (x, y) => {
    const dx = x[second] - x[first], dy = y[second] - y[first], size = Math.hypot(dx, dy), [ux, uy] = size > 0 ? [dx / size, dy / size] : [1, 0];
    return [{ value: size - length, by: [[first, -ux, -uy], [second, ux, uy]] }];
  },
  miss: ([value]) => Math.abs(value),
});

/** Keeps each line at a width. @param {number[]} ends the points at their ends @param {number} width @returns {Term} */
const width = (ends, width) => ({
  weight: PIN_WEIGHT, rows: (x) => ends.map((end) => ({ value: x[end] - width, by: [[end, 1, 0]] })), miss: (values) => Math.max(...values.map(Math.abs)),
});

/**
 * @typedef {{kind: "SharedX" | "SharedY" | "Collinear" | "Distance" | "Width", handles: import("../word/forward.js").Handle[], value?: number}} Constraint
 *   `value`: the distance or the width, in font units
 */

/**
 * The term of a constraint on some points; those of a width are the ends of the lines.
 * @param {Constraint} constraint @param {number[]} points @returns {Term}
 */
export function constraintTerm({ kind, value = 0 }, points) {
  switch (kind) {
    case "SharedX": return aligned(points, 0);
    case "SharedY": return aligned(points, 1);
    case "Collinear": return collinear(points);
    case "Distance": return distance(points, value);
    case "Width": return width(points, value);
  }
}
