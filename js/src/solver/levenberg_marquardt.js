/**
 * Bounded Levenberg–Marquardt for piecewise smooth residuals, as `vfwidget.solver` in Python, for the
 * energies of a drag: few residuals, and λ ‖x − home‖². Both follow the same rules, so they find the same places.
 */
import { add, dot, largest, minimiseInBox } from "./box.js";

/**
 * @typedef {object} Problem
 * @property {(x: Float64Array) => {residual: Float64Array, jacobian: Float64Array[]}} evaluate new arrays, one row of
 *   the Jacobian for each residual
 * @property {Float64Array} lower
 * @property {Float64Array} upper
 * @property {number[][]} kinks for each variable the values at which the residual may have a kink
 * @property {number} pull λ
 * @property {Float64Array} home
 * @typedef {{x: Float64Array, cost: number, residual: Float64Array, converged: boolean, active: Int8Array}} Minimum
 *   `active`: −1 or 1 where the lower or upper bound holds a variable
 */

/** The distance from a kink at which its one-sided derivatives are evaluated. */
const NUDGE = 1e-8;
const INITIAL_DAMPING = 1e-4, LEAST_DAMPING = 1e-14, GROWN_OUT = 2 ** 40;
/** Shares of the promised decrease: below the first a step is tried again within the kinks around it. */
const GOOD_GAIN = 0.75, LEAST_GAIN = 1e-3, GREAT_GAIN = 0.9, BOLD = 0.03;
/** Cost decrease (squared font units) and step (normalized) below which the solver stops. */
const GAIN = 1e-4, STEP = 1e-9, FLAT = 1e-10;

/**
 * @param {Problem} problem @param {Float64Array} start @param {number} maxIterations
 * @param {number} [milliseconds] ends the solve after this time, at the best place so far
 * @returns {Minimum}
 */
export function minimise(problem, start, maxIterations, milliseconds = Infinity) {
  const { lower, upper, home, pull } = problem;
  let x = start.map((v, i) => settle(problem, i, v));
  let { residual } = problem.evaluate(x);
  const costOf = (/** @type {Float64Array} */ r, /** @type {Float64Array} */ at) => dot(r, r) + pull * squaredDistance(at, home);
  let cost = costOf(residual, x), damping = 0, growth = 2, iterations = 0, converged = false;
  let model = linearise(problem, x, residual);
  const attempt = (/** @type {Float64Array} */ low, /** @type {Float64Array} */ high) => {
    const d = minimiseInBox(model, pull + damping, low, high);
    const next = x.map((v, i) => Math.min(upper[i], Math.max(lower[i],
      d[i] >= high[i] ? v + high[i] : d[i] <= low[i] ? v + low[i] : v + d[i])));
    const moved = problem.evaluate(next).residual;
    const ahead = residual.map((f, k) => f + dot(model.jacobian[k], d));
    const promised = dot(residual, residual) - dot(ahead, ahead) - 2 * dot(model.pull, d) - pull * dot(d, d);
    const reached = costOf(moved, next);
    return { d, x: next, residual: moved, cost: reached, promised, gain: promised > 0 ? (cost - reached) / promised : -Infinity };
  };
  const end = performance.now() + milliseconds;
  while (iterations < maxIterations && performance.now() < end) {
    if (cost <= GAIN || atRest(model, cost)) {
      converged = true;
      break;
    }
    damping = Math.max(damping || INITIAL_DAMPING * model.unit, LEAST_DAMPING * model.unit);
    let trial = attempt(model.low, model.high);
    if (trial.gain < GOOD_GAIN) {
      const [low, high] = cell(problem, x, model);
      if (trial.d.some((v, i) => v < low[i] || v > high[i])) {
        const inside = attempt(low, high);
        if (inside.cost < trial.cost) trial = inside;
      }
    }
    const length = largest(trial.x.map((v, i) => v - x[i])), short = length <= STEP * (1 + largest(x));
    if (trial.gain > LEAST_GAIN && trial.cost < cost) {
      const idle = cost - trial.cost <= GAIN && trial.promised <= 10 * GAIN;
      ({ x, residual, cost } = trial);
      damping *= trial.gain > GREAT_GAIN ? BOLD : 1 - (2 * trial.gain - 1) ** 3;
      growth = 2;
      iterations++;
      converged = short || idle;
      model = linearise(problem, x, residual);
    } else {
      damping *= growth;
      growth *= 2;
      converged = short || trial.promised <= 2e-16 * cost || growth > GROWN_OUT;
    }
    if (converged) break;
  }
  const active = Int8Array.from(x, (v, i) => {
    if (lower[i] === upper[i]) return 0;
    return v >= upper[i] && model.slope[i] < 0 ? 1 : v <= lower[i] && model.slope[i] > 0 ? -1 : 0;
  });
  return { x, cost, residual, converged, active };
}

/** A start within rounding of a kink or a bound is meant to be on it. @param {Problem} problem @param {number} i @param {number} v */
function settle({ lower, upper, kinks }, i, v) {
  for (const place of [...kinks[i], lower[i], upper[i]]) if (Math.abs(v - place) < NUDGE) v = place;
  return Math.min(upper[i], Math.max(lower[i], v));
}

/**
 * The linear model of the sides that go down, and the room there is on them. A variable on a kink has a slope to
 * either side: it takes the side that falls, the steeper if both do, and rests if neither does.
 * @param {Problem} problem @param {Float64Array} x @param {Float64Array} residual
 */
function linearise(problem, x, residual) {
  const { lower, upper, kinks, home } = problem;
  const low = x.map((v, i) => lower[i] - v), high = x.map((v, i) => upper[i] - v);
  const pull = x.map((v, i) => problem.pull * (v - home[i]));
  const onKink = x.map((v, i) => (kinks[i].some((kink) => Math.abs(kink - v) < NUDGE) ? 1 : 0));
  const oneSided = (/** @type {1 | -1} */ side) => problem.evaluate(x.map((v, i) => {
    if (!onKink[i]) return v;
    return v + NUDGE * (side > 0 ? (high[i] > 0 ? 1 : -1) : low[i] < 0 ? -1 : 1);
  })).jacobian;
  const jacobian = oneSided(1);
  let slope = slopeOf(jacobian, residual, pull);
  const both = x.map((_, i) => (onKink[i] && low[i] < 0 && high[i] > 0 ? 1 : 0));
  if (both.some(Boolean)) {
    const behind = oneSided(-1), other = slopeOf(behind, residual, pull);
    for (let i = 0; i < x.length; i++) {
      if (!both[i]) continue;
      const falls = Math.max(-slope[i], other[i]);
      if (other[i] === falls && falls > 0) jacobian.forEach((row, k) => (row[i] = behind[k][i]));
      if (!(falls > 0) || other[i] === falls) high[i] = 0;
      if (!(falls > 0) || other[i] !== falls) low[i] = 0;
    }
    slope = slopeOf(jacobian, residual, pull);
  }
  const columns = x.map((_, i) => problem.pull + jacobian.reduce((sum, row) => sum + row[i] * row[i], 0));
  return { residual, jacobian, pull, slope, columns, low, high, unit: largest(columns) };
}

/** Half the derivative of the cost. @param {Float64Array[]} jacobian @param {Float64Array} residual @param {Float64Array} pull */
function slopeOf(jacobian, residual, pull) {
  const slope = Float64Array.from(pull);
  residual.forEach((f, k) => add(slope, f, jacobian[k]));
  return slope;
}

/** Can no variable move and lower the cost? @param {ReturnType<typeof linearise>} model @param {number} cost */
function atRest({ slope, columns, low, high }, cost) {
  return !slope.some((s, i) => (s > 0 ? low[i] < 0 : high[i] > 0) && Math.abs(s) > FLAT * Math.sqrt(columns[i] * cost));
}

/**
 * The room up to the next kinks. @param {Problem} problem @param {Float64Array} x
 * @param {ReturnType<typeof linearise>} model @returns {[Float64Array, Float64Array]}
 */
function cell({ kinks }, x, model) {
  const gaps = (/** @type {number} */ i) => kinks[i].map((kink) => kink - x[i]);
  return [
    model.low.map((v, i) => Math.max(v, ...gaps(i).filter((gap) => gap < -NUDGE))),
    model.high.map((v, i) => Math.min(v, ...gaps(i).filter((gap) => gap > NUDGE))),
  ];
}

/** @param {Float64Array} a @param {Float64Array} b */
function squaredDistance(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += (a[i] - b[i]) ** 2;
  return sum;
}
