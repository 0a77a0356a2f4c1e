/**
 * The minimum of a damped linear model over a box. The model has few residuals and many variables:
 * q(d) = ½ ‖F + J d‖² + s·d + ½ c ‖d‖², so every system that is solved has the size of the residuals.
 */

/**
 * @typedef {{residual: Float64Array, jacobian: Float64Array[], pull: Float64Array}} Model  F, the rows of J, and s
 */

/** Halvings of a step, and the share of the linear decrease that a step must achieve. */
const HALVINGS = 30, SUFFICIENT = 0.1;
/** A change of this size is rounding. */
const STILL = 1e-12;

/**
 * Projected Newton (Bertsekas 1982): variables that the slope holds at a bound are fixed, and the others
 * take the Newton step of their own system, clipped to the box and halved until q falls enough.
 * @param {Model} model @param {number} c > 0 @param {ArrayLike<number>} low ≤ 0 @param {ArrayLike<number>} high ≥ 0
 */
export function minimiseInBox(model, c, low, high) {
  const { residual, jacobian, pull } = model, d = new Float64Array(pull.length);
  // Variables that nothing moves are left out: the letters that a drag does not touch.
  const moving = [];
  for (let i = 0; i < d.length; i++) {
    if (low[i] < high[i] && (pull[i] !== 0 || jacobian.some((row) => row[i] !== 0))) moving.push(i);
  }
  const slope = new Float64Array(d.length), change = new Float64Array(d.length);
  for (let round = 0; round < 10 + 4 * moving.length; round++) {
    for (const i of moving) slope[i] = pull[i] + c * d[i];
    for (let k = 0; k < residual.length; k++) {
      const f = residual[k] + along(moving, jacobian[k], d);
      for (const i of moving) slope[i] += f * jacobian[k][i];
    }
    const free = moving.filter((i) => (slope[i] > 0 ? d[i] > low[i] : slope[i] < 0 && d[i] < high[i]));
    if (free.length === 0) break;
    const newton = solveFree(model, c, d, free);
    for (let length = 1, tries = 0; tries < HALVINGS; tries++, length /= 2) {
      for (const i of moving) change[i] = Math.min(high[i], Math.max(low[i], d[i] + length * (newton[i] - d[i]))) - d[i];
      const linear = along(moving, change, slope);
      let bent = c * along(moving, change, change);
      for (const row of jacobian) bent += along(moving, row, change) ** 2;
      if (linear + bent / 2 <= SUFFICIENT * linear) break;
    }
    for (const i of moving) d[i] += change[i];
    if (largest(change) <= STILL) break;
  }
  return d;
}

/** The dot product over some of the variables. @param {number[]} moving @param {Float64Array} a @param {Float64Array} b */
function along(moving, a, b) {
  let sum = 0;
  for (const i of moving) sum += a[i] * b[i];
  return sum;
}

/**
 * The minimum over the free variables while the others stay at d. By the Woodbury identity it is
 * −s/c − Jᵀ (J Jᵀ + c)⁻¹ (F − J s/c), with the columns of the free variables only.
 * @param {Model} model @param {number} c @param {Float64Array} d @param {number[]} free
 */
function solveFree({ residual, jacobian, pull }, c, d, free) {
  const x = Float64Array.from(d);
  for (const i of free) x[i] = -pull[i] / c;
  const right = residual.map((f, k) => f + dot(jacobian[k], x));
  const gram = jacobian.map((row, k) => {
    const half = new Float64Array(k + 1);
    for (let l = 0; l <= k; l++) half[l] = along(free, row, jacobian[l]);
    half[k] += c;
    return half;
  });
  const solution = solveSymmetric(gram, right);
  for (let k = 0; k < right.length; k++) for (const i of free) x[i] -= solution[k] * jacobian[k][i];
  return x;
}

/** Cholesky; the matrix is overwritten. @param {Float64Array[]} a the lower half of a positive definite matrix @param {Float64Array} b */
function solveSymmetric(a, b) {
  const m = b.length, x = Float64Array.from(b);
  for (let k = 0; k < m; k++) {
    for (let l = 0; l <= k; l++) {
      let sum = a[k][l];
      for (let i = 0; i < l; i++) sum -= a[k][i] * a[l][i];
      a[k][l] = k === l ? Math.sqrt(Math.max(sum, Number.MIN_VALUE)) : sum / a[l][l];
    }
    for (let i = 0; i < k; i++) x[k] -= a[k][i] * x[i];
    x[k] /= a[k][k];
  }
  for (let k = m - 1; k >= 0; k--) {
    for (let i = k + 1; i < m; i++) x[k] -= a[i][k] * x[i];
    x[k] /= a[k][k];
  }
  return x;
}

/** @param {ArrayLike<number>} a @param {ArrayLike<number>} b */
export function dot(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += a[i] * b[i];
  return sum;
}

/** out += factor · row. @param {Float64Array} out @param {number} factor @param {ArrayLike<number>} row */
export function add(out, factor, row) {
  for (let i = 0; i < out.length; i++) out[i] += factor * row[i];
}

/** @param {ArrayLike<number>} a */
export function largest(a) {
  let most = 0;
  for (let i = 0; i < a.length; i++) most = Math.max(most, Math.abs(a[i]));
  return most;
}
