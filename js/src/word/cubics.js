/** Points on cubics: evaluation, and the point of an outline that is nearest to a place. */

/** Coarse samples a segment: enough that every local minimum of the distance shows between two. */
const SAMPLES = 12;

/** The weights of a cubic's four control points. @param {number} t */
export function bernstein(t) {
  const u = 1 - t;
  return [u * u * u, 3 * u * u * t, 3 * u * t * t, t * t * t];
}

/** One coordinate of a cubic. @param {number} a @param {number} b @param {number} c @param {number} d @param {number} t */
export function cubic(a, b, c, d, t) {
  const u = 1 - t;
  return u * u * u * a + 3 * u * u * t * b + 3 * u * t * t * c + t * t * t * d;
}

/**
 * The nearest point of one cubic. Between the neighbours of a coarse minimum, Newton on
 * (B − q)·B′ = 0, bisecting where Newton leaves the bracket; a result worse than its sample (cusps,
 * degenerate segments) is not taken.
 * @param {Float64Array} p x0, y0 … x3, y3 @param {number} x @param {number} y
 * @returns {{t: number, d2: number}} d2: squared distance
 */
export function nearestOnCubic(p, x, y) {
  const [x0, y0, x1, y1, x2, y2, x3, y3] = p;
  const at = (/** @type {number} */ t) => {
    const dx = cubic(x0, x1, x2, x3, t) - x, dy = cubic(y0, y1, y2, y3, t) - y;
    return dx * dx + dy * dy;
  };
  for (let i = 0; i <= SAMPLES; i++) samples[i] = at(i / SAMPLES);
  let t = 0, d2 = Infinity;
  for (let i = 0; i <= SAMPLES; i++) {
    const d = samples[i];
    if ((i > 0 && samples[i - 1] < d) || (i < SAMPLES && samples[i + 1] < d)) continue;
    if (d < d2) [t, d2] = [i / SAMPLES, d];
    const refined = descend(p, x, y, Math.max(0, i - 1) / SAMPLES, i / SAMPLES, Math.min(SAMPLES, i + 1) / SAMPLES);
    const value = at(refined);
    if (value < d2) [t, d2] = [refined, value];
  }
  return { t, d2 };
}

const samples = new Float64Array(SAMPLES + 1);

/** @param {Float64Array} p @param {number} x @param {number} y @param {number} low @param {number} t @param {number} high */
function descend([x0, y0, x1, y1, x2, y2, x3, y3], x, y, low, t, high) {
  for (let i = 0; i < 40; i++) {
    const u = 1 - t;
    const dx = cubic(x0, x1, x2, x3, t) - x, dy = cubic(y0, y1, y2, y3, t) - y;
    const vx = 3 * (u * u * (x1 - x0) + 2 * u * t * (x2 - x1) + t * t * (x3 - x2));
    const vy = 3 * (u * u * (y1 - y0) + 2 * u * t * (y2 - y1) + t * t * (y3 - y2));
    const ax = 6 * (u * (x2 - 2 * x1 + x0) + t * (x3 - 2 * x2 + x1));
    const ay = 6 * (u * (y2 - 2 * y1 + y0) + t * (y3 - 2 * y2 + y1));
    const slope = dx * vx + dy * vy, bend = vx * vx + vy * vy + dx * ax + dy * ay;
    if (slope > 0) high = t;
    else low = t;
    let next = bend > 0 ? t - slope / bend : NaN;
    if (!(next > low && next < high)) next = (low + high) / 2;
    if (Math.abs(next - t) < 1e-10) return next;
    t = next;
  }
  return t;
}

const segment = new Float64Array(8);

/**
 * The outline point of a laid-out word that is nearest to (x, y), or null when none lies within reach.
 * A segment whose control polygon is farther than the best so far is skipped: the hull holds the curve.
 * @param {import("./forward.js").Layout} layout @param {number} x @param {number} y @param {number} [within]
 * @returns {{glyph: number, contour: number, segment: number, t: number, x: number, y: number, distance: number} | null}
 */
export function nearest(layout, x, y, within = Infinity) {
  let best = within * within, found = null;
  for (let glyph = 0; glyph < layout.points.length; glyph++) {
    const points = layout.points[glyph], { contours, starts } = layout.glyphs[glyph];
    const qx = x - layout.x[glyph], qy = y - layout.y[glyph];
    for (let contour = 0; contour < contours.length; contour++) {
      const size = 3 * contours[contour];
      for (let s = 0; s < contours[contour]; s++) {
        let left = Infinity, right = -Infinity, bottom = Infinity, top = -Infinity;
        for (let i = 0; i < 4; i++) {
          const at = 2 * (starts[contour] + ((3 * s + i) % size));
          const px = segment[2 * i] = points[at], py = segment[2 * i + 1] = points[at + 1];
          if (px < left) left = px;
          if (px > right) right = px;
          if (py < bottom) bottom = py;
          if (py > top) top = py;
        }
        const gapX = Math.max(left - qx, 0, qx - right), gapY = Math.max(bottom - qy, 0, qy - top);
        if (gapX * gapX + gapY * gapY > best) continue;
        const { t, d2 } = nearestOnCubic(segment, qx, qy);
        if (d2 > best || (found !== null && d2 === best)) continue;
        best = d2;
        // The end of a segment is the start of the next: one name for one point.
        found = t < 1 ? { glyph, contour, segment: s, t } : { glyph, contour, segment: (s + 1) % contours[contour], t: 0 };
      }
    }
  }
  if (found === null) return null;
  const [px, py] = layout.position([found.glyph, found.contour, found.segment, found.t]);
  return { ...found, x: px, y: py, distance: Math.sqrt(best) };
}
