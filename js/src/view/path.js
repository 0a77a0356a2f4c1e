/** Outlines as the path data of SVG. */

/** @typedef {import("../word/forward.js").Layout} Layout */

/** A length in font units, to a tenth of a unit: no screen shows the difference. */
export const round = (/** @type {number} */ v) => Math.round(v * 10) / 10;

/** Path data of closed contours, y down. @param {ArrayLike<number>} p @param {number[]} contours @param {number[]} starts */
export function path(p, contours, starts) {
  let d = "";
  for (let c = 0; c < contours.length; c++) {
    if (contours[c] === 0) continue;
    const size = 3 * contours[c];
    const at = 2 * starts[c];
    d += `M${round(p[at])} ${round(-p[at + 1])}`;
    for (let i = 1; i <= size; i++) {
      const o = at + 2 * (i % size);
      d += `${i % 3 === 1 ? "C" : " "}${round(p[o])} ${round(-p[o + 1])}`;
    }
    d += "Z";
  }
  return d;
}

/** Path data of a laid-out letter relative to its origin. @param {Layout} layout @param {number} letter */
export const pathData = ({ points, glyphs }, letter) => path(points[letter], glyphs[letter].contours, glyphs[letter].starts);
