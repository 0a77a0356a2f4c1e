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
