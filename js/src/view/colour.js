/** Colour glyphs as SVG, drawn as `vfwidget/export/paint.py` draws them. */
import { path } from "./drawing.js";
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

/** @param {Layer} layer @param {import("../word/forward.js").Regions} regions @param {ArrayLike<number>} w */
function drawn({ outline, contours, starts, kind, numbers, frame, extend, colours, alphas }, regions, w) {
  const d = path(evaluate(outline, regions, w), contours, starts), values = evaluate(numbers, regions, w), s = colours.length;
  const size = values.length - 2 * s, [x, y, ax, ay, bx, by] = evaluate(frame, regions, w);
  const stops = colours.map((rgb, i) => ({
    at: values[size + i], rgb, fill: rgb ? `rgb(${rgb})` : "currentColor",
    alpha: alphas[i] * Math.min(1, Math.max(0, values[size + s + i])),
  })).sort((a, b) => a.at - b.at);
  if (kind === "solid") return svg("path", { d, fill: stops[0].fill, "fill-opacity": stops[0].alpha });
  // SVG knows no stops beyond 0 and 1, so the gradient is moved to the first and the last stop.
  const low = stops[0].at, span = stops[s - 1].at - low || 1;
  for (const stop of stops) stop.at = (stop.at - low) / span;
  const id = `vfw-paint-${count++}`, matrix = `matrix(${[ax - x, y - ay, bx - x, y - by, x, -y]})`;
  const part = (/** @type {number} */ from, /** @type {number} */ to, /** @type {number} */ t) =>
    values[from] + (values[to] - values[from]) * (low + span * t);
  if (kind === "sweep") {
    return svg("g", {}, svg("clipPath", { id }, svg("path", { d })), svg("g", { "clip-path": `url(#${id})` },
      svg("g", { transform: matrix, "shape-rendering": "crispEdges" }, ...wedges(values[0], values[1], part(2, 3, 0), part(2, 3, 1), stops, extend))));
  }
  // In SVG a radial gradient runs outwards, and no radius is negative.
  const [a, b] = kind === "radial" && part(2, 5, 0) > part(2, 5, 1) ? [1, 0] : [0, 1];
  if (a) for (const stop of stops.reverse()) stop.at = 1 - stop.at;
  const places = kind === "linear" ? line(values, part)
    : { fx: part(0, 3, a), fy: part(1, 4, a), fr: Math.max(0, part(2, 5, a)), cx: part(0, 3, b), cy: part(1, 4, b), r: Math.max(0, part(2, 5, b)) };
  return svg("g", {}, svg(kind === "linear" ? "linearGradient" : "radialGradient",
    { id, gradientUnits: "userSpaceOnUse", gradientTransform: matrix, spreadMethod: extend, ...places },
    ...stops.map(({ at, fill, alpha }) => svg("stop", { offset: at, "stop-color": fill, "stop-opacity": alpha }))),
  svg("path", { d, fill: `url(#${id})` }));
}

/**
 * The ends of a linear gradient. Lines of equal colour are parallel to the one through its first and its third point.
 * @param {number[]} values @param {(from: number, to: number, t: number) => number} part
 */
function line(values, part) {
  const [x, y] = values, dx = y - values[5], dy = values[4] - x;
  const share = ((values[2] - x) * dx + (values[3] - y) * dy) / (dx * dx + dy * dy || Infinity);
  values[2] = x + share * dx;
  values[3] = y + share * dy;
  return { x1: part(0, 2, 0), y1: part(1, 3, 0), x2: part(0, 2, 1), y2: part(1, 3, 1) };
}

/** @param {number} x @param {number} y @param {number} start degrees @param {number} end @param {Stop[]} stops @param {string} extend */
function wedges(x, y, start, end, stops, extend) {
  return Array.from({ length: WEDGES }, (_, i) => {
    const ray = (/** @type {number} */ k) => {
      const angle = (2 * Math.PI * k) / WEDGES;
      return `L${x + REACH * Math.cos(angle)} ${y + REACH * Math.sin(angle)}`;
    };
    let t = ((i + 0.5) * (360 / WEDGES) - start) / (end - start);
    if (extend === "repeat") t -= Math.floor(t);
    if (extend === "reflect") t = 1 - Math.abs(t - 2 * Math.floor(t / 2) - 1);
    const after = Math.max(1, stops.findIndex(({ at }) => at > t)), b = t < 1 ? stops[after] : stops[stops.length - 1], a = t < 1 ? stops[after - 1] : b;
    const share = b.at > a.at ? Math.max(0, (t - a.at) / (b.at - a.at)) : 1, mix = (/** @type {number} */ p, /** @type {number} */ q) => p + share * (q - p);
    const rgb = [0, 1, 2].map((k) => Math.round(mix(a.rgb?.[k] ?? 0, b.rgb?.[k] ?? 0)));
    return svg("path", { d: `M${x} ${y}${ray(i)}${ray(i + 1)}Z`, fill: `rgb(${rgb})`, "fill-opacity": mix(a.alpha, b.alpha) });
  });
}
