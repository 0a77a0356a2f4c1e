/** Colour glyphs as SVG, drawn as `vfwidget/export/paint.py` draws them. */
import { path } from "./path.js";
import { svg } from "./dom.js";
import { evaluate } from "../word/varying.js";

/** @typedef {import("../word/decode.js").Layer} Layer @typedef {{at: number, rgb: number[] | null, fill: string, alpha: number}} Stop */

/** SVG has no sweep gradient; one is drawn as so many wedges of one colour each. */
const WEDGES = 120;
/** Wedges reach farther than any outline, in font units. */
const REACH = 1e5;

let count = 0;

/** The layers of one letter, relative to its origin. @param {import("../word/forward.js").Layout} layout @param {number} letter */
export const layers = (layout, letter) => layout.glyphs[letter].layers.map((layer) => drawn(layer, layout.word.regions, layout.placeOf(letter)));

/** @param {Layer} layer @param {import("../word/regions.js").Regions} regions @param {ArrayLike<number>} w */
function drawn({ outline, contours, starts, kind, numbers, frame, extend, colours, alphas }, regions, w) {
  const d = path(evaluate(outline, regions, w), contours, starts), values = evaluate(numbers, regions, w), s = colours.length;
  const size = values.length - 2 * s, [x, y, ax, ay, bx, by] = evaluate(frame, regions, w), [p, q, u, v, m, n] = values;
  const stops = colours.map((rgb, i) => ({
    at: values[size + i], rgb, fill: rgb ? `rgb(${rgb})` : "currentColor",
    alpha: alphas[i] * Math.min(1, Math.max(0, values[size + s + i])),
  })).sort((a, b) => a.at - b.at);
  if (!size) return svg("path", { d, fill: stops[0].fill, "fill-opacity": stops[0].alpha });
  // SVG knows no stops beyond 0 and 1, so the gradient is moved to the first and the last stop.
  const low = stops[0].at, span = stops[s - 1].at - low || 1;
  if (stops[s - 1].at === low) extend = "pad";
  const ends = (/** @type {number[]} */ from, /** @type {number[]} */ to) =>
    [low, low + span].map((t) => from.map((one, i) => one + (to[i] - one) * t));
  for (const stop of stops) stop.at = (stop.at - low) / span;
  const id = `vfw-paint-${count++}`, matrix = `matrix(${[ax - x, y - ay, bx - x, y - by, x, -y]})`;
  if (size === 4) {
    const [[from], [to]] = ends([u], [v]), clip = svg("clipPath", { id }, svg("path", { d }));
    return svg("g", {}, clip, svg("g", { "clip-path": `url(#${id})` },
      svg("g", { transform: matrix, "shape-rendering": "crispEdges" }, ...wedges(p, q, from, to, stops, extend))));
  }
  let places;
  if (kind === "linear") {
    // Lines of equal colour are parallel to the one through the first and the third point.
    const dx = q - n, dy = m - p, share = ((u - p) * dx + (v - q) * dy) / (dx * dx + dy * dy || Infinity);
    const [[x1, y1], [x2, y2]] = ends([p, q], [p + share * dx, q + share * dy]);
    places = { x1, y1, x2, y2 };
  } else {
    // In SVG a radial gradient runs outwards, and no radius is negative.
    const circles = ends([p, q, u], [v, m, n]);
    if (circles[0][2] > circles[1][2]) {
      circles.reverse();
      for (const stop of stops.reverse()) stop.at = 1 - stop.at;
    }
    const [[fx, fy, fr], [cx, cy, r]] = circles;
    places = { fx, fy, fr: Math.max(0, fr), cx, cy, r: Math.max(0, r) };
  }
  return svg("g", {}, svg(kind === "linear" ? "linearGradient" : "radialGradient",
    { id, gradientUnits: "userSpaceOnUse", gradientTransform: matrix, spreadMethod: extend, ...places },
    ...stops.map(({ at, fill, alpha }) => svg("stop", { offset: at, "stop-color": fill, "stop-opacity": alpha }))),
  svg("path", { d, fill: `url(#${id})` }));
}

/** @param {number} x @param {number} y @param {number} start degrees @param {number} end @param {Stop[]} stops @param {string} extend */
function wedges(x, y, start, end, stops, extend) {
  return Array.from({ length: WEDGES }, (_, i) => {
    const ray = (/** @type {number} */ k) =>
      `L${x + REACH * Math.cos((2 * Math.PI * k) / WEDGES)} ${y + REACH * Math.sin((2 * Math.PI * k) / WEDGES)}`;
    const angle = (i + 0.5) * (360 / WEDGES);
    // Without an arc, all angles lie beyond one of the ends.
    let t = start === end ? (angle < start ? -1 : 2) : (angle - start) / (end - start);
    if (extend === "repeat") t -= Math.floor(t);
    if (extend === "reflect") t = 1 - Math.abs(t - 2 * Math.floor(t / 2) - 1);
    const after = stops.findIndex(({ at }) => at > t), b = stops[after < 0 ? stops.length - 1 : after], a = after > 0 ? stops[after - 1] : b;
    const share = b.at > a.at ? (t - a.at) / (b.at - a.at) : 1, mix = (/** @type {number} */ one, /** @type {number} */ other) => one + share * (other - one);
    const rgb = [0, 1, 2].map((k) => Math.round(mix(a.rgb?.[k] ?? 0, b.rgb?.[k] ?? 0)));
    return svg("path", { d: `M${x} ${y}${ray(i)}${ray(i + 1)}Z`, fill: `rgb(${rgb})`, "fill-opacity": mix(a.alpha, b.alpha) });
  });
}
