/** The regions of the design space in which deltas apply, and how much they apply there (Eq. 2). No DOM. */

/**
 * @typedef {{count: number, first: Int32Array, axis: Int32Array, start: Float64Array,
 *   peak: Float64Array, end: Float64Array}} Regions  the supports, only the axes that matter:
 *   region j owns entries first[j] … first[j + 1] − 1
 */

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
