/** Quantities that are not affine in one set of scalars, as `vfwidget/view/varying.py` describes them. No DOM. */
import { scalar } from "./regions.js";

/** @typedef {[kind: string, ...parts: any[]]} Node  a kind of quantity and its parts, which may be nodes again */

const clamp = (/** @type {number} */ v) => Math.min(1, Math.max(-1, v));

/**
 * A quantity at normalized coordinates.
 * @param {Node} node @param {import("./regions.js").Regions} regions @param {ArrayLike<number>} w
 * @returns {number[]}
 */
export function evaluate([kind, ...parts], regions, w) {
  const at = (/** @type {Node} */ part, v = w) => evaluate(part, regions, v), [a, b, c] = parts;
  switch (kind) {
    case "affine": {
      const size = a.length / (1 + b.length), out = Array.from(a.subarray(0, size));
      b.forEach((/** @type {number} */ region, /** @type {number} */ j) => {
        const g = scalar(regions, region, w), start = size * (1 + j);
        for (let i = 0; i < size && g; i++) out[i] += g * a[start + i];
      });
      return /** @type {number[]} */ (out);
    }
    case "composed": return at(a, at(b));
    case "displaced": return at(a).map((d, i) => clamp(w[i] + d));
    case "replaced": {
      const values = at(c), out = [...at(a)];
      b.forEach((/** @type {number} */ axis, /** @type {number} */ i) => (out[axis] = clamp(values[i])));
      return out;
    }
    case "turned": {
      // A = rotation · scale · skew about a center, then a translation.
      const [dx, dy, angle, sx, sy, kx, ky, x, y] = at(a), s = Math.sin(angle), r = Math.cos(angle), u = Math.tan(kx), v = Math.tan(ky);
      const [xx, xy, yx, yy] = [r * sx - s * sy * v, r * sx * u - s * sy, s * sx + r * sy * v, s * sx * u + r * sy];
      return [xx, xy, x + dx - xx * x - xy * y, yx, yy, y + dy - yx * x - yy * y];
    }
    case "placed": {
      const [xx, xy, dx, yx, yy, dy] = at(b);
      return at(a).map((v, i, p) => (i % 2 ? yx * p[i - 1] + yy * v + dy : xx * v + xy * p[i + 1] + dx));
    }
    case "joined": return parts.flatMap((part) => at(part));
    case "shown": return at(b)[0] ? at(a) : at(a).map(() => 0);
    case "range": return [Number(w[a] >= b && w[a] <= c)];
    case "positive": return [Number(at(a)[0] > 0)];
    case "all": return [Number(parts.every((part) => at(part)[0]))];
    case "not": return [1 - at(a)[0]];
    default: throw new Error(`the view does not know a quantity of the kind ${kind}`);
  }
}
