/**
 * Reads the word a kernel (or an exported page) hands over: JSON with binary buffers in, typed
 * arrays out, everything checked once so that the drawing loop need not.
 */
import { compile } from "./regions.js";

export const { isArray } = Array;

/** @typedef {import("./rows.js").Row} Row */
/** @typedef {import("./varying.js").Node} Node */
/**
 * @typedef {{contours: number[], starts: number[], outline: Node, kind: string, numbers: Node, frame: Node, extend: string,
 *   colours: (number[] | null)[], alphas: number[]}} Layer
 * @typedef {{tag: string, name: string, minimum: number, default: number, maximum: number,
 *   hidden: boolean, map: [number, number][]}} Axis
 * @typedef {{name: string, contours: number[], starts: number[], k: number, points: Float32Array,
 *   regions: number[], outline?: Node, advance: {default: number, regions: number[], deltas: number[]},
 *   layers: Layer[]}} Glyph
 *   `starts`: a contour's first point; region scalars times deltas move points and advance, or `outline` has the points
 * @typedef {{family: string, string: string, unitsPerEm: number, ascender: number, descender: number,
 *   instances: {name: string, axes: Record<string, number>}[], axes: Axis[], regions: import("./regions.js").Regions,
 *   final?: Node, kinks?: number[][], glyphs: Glyph[], rows: Row[], settings: {edges: number[][], cells: number[]}, tracking: number,
 *   offsets: [number, number][]}} Word
 */

/** @param {boolean} condition @param {string} what */
function check(condition, what) {
  if (!condition) throw new Error(`this part of the word is malformed: ${what}`);
}

const finite = (/** @type {unknown} */ v) => typeof v === "number" && Number.isFinite(v);

/**
 * Little-endian float32 numbers from whatever carries them; base64 because JSON (an exported page)
 * has no bytes. Copied, since a comm buffer may start at any byte.
 * @param {any} data @param {number} length @param {string} what
 */
export function floats(data, length, what) {
  if (length === 0) return new Float32Array(0);
  if (typeof data === "string") data = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
  check(data?.byteLength === 4 * length, what);
  const bytes = new DataView(data.buffer ?? data, data.byteOffset ?? 0);
  return Float32Array.from({ length }, (_, i) => bytes.getFloat32(4 * i, true));
}

/** A quantity whose numbers are still bytes. @param {any} raw @returns {Node} */
function node([kind, ...parts]) {
  if (kind !== "affine") return [kind, ...parts.map((part) => (typeof part?.[0] === "string" ? node(part) : part))];
  const [data, regions, size] = parts;
  return [kind, floats(data, size * (1 + regions.length), "a quantity"), regions];
}

/** @param {any} raw @returns {Axis} */
function axis({ tag, name, minimum, default: normal, maximum, hidden, map }) {
  map = map?.length ? map : [[-1, -1], [0, 0], [1, 1]];
  check([minimum, normal, maximum].every(finite) && minimum <= normal && normal <= maximum
    && map.every((/** @type {any} */ p, /** @type {number} */ i) => finite(p[0]) && finite(p[1]) && (i === 0 || map[i - 1][0] <= p[0])),
  `axis ${tag}`);
  return { tag, name: name || tag, minimum, default: normal, maximum, hidden: Boolean(hidden), map };
}

/** The number of points before each contour, and of all. @param {number[]} contours */
function firsts(contours) {
  let k = 0;
  const starts = contours.map((s) => {
    check(Number.isInteger(s) && s >= 0, "contours");
    return (k += 3 * s) - 3 * s;
  });
  return { starts, k };
}

/** @param {any} raw @param {number} count of regions @returns {Glyph} */
function glyph({ name, contours, points, regions = [], outline, advance, layers = [] }, count) {
  const known = (/** @type {number[]} */ list) => list.every((r) => r >= 0 && r < count);
  const { starts, k } = firsts(contours);
  check(known(regions) && known(advance.regions) && advance.deltas.length === advance.regions.length
    && [advance.default, ...advance.deltas].every(finite), `glyph ${name}`);
  return {
    name, contours, starts, k, regions, advance, outline: outline && node(outline),
    layers: layers.map((/** @type {any} */ layer) => ({
      ...layer, starts: firsts(layer.contours).starts,
      outline: node(layer.outline), numbers: node(layer.numbers), frame: node(layer.frame),
    })),
    points: floats(points, outline ? 0 : 2 * k * (1 + regions.length), `glyph ${name}`),
  };
}

/** @param {any} raw @param {number} glyphs how many there are @param {number} count of regions @returns {Row} */
function row(raw, glyphs, count) {
  const index = (/** @type {any} */ v, /** @type {number} */ length, low = 0) => Number.isInteger(v) && v >= low && v < length;
  const form = (/** @type {any} */ f) => finite(f.default) && f.regions.length === f.deltas.length && f.deltas.every(finite)
    && f.regions.every((/** @type {any} */ r) => index(r, count));
  const { order, anchors, pushed, own, anchored, gaps, clusters, names, lines, bases } = raw, l = order.length, r = anchors.length;
  // A chain of anchors that returned to its start would have no end.
  const ends = (/** @type {number} */ i, steps = 0) => i < 0 || (index(i, r) && steps < r && ends(anchors[i], steps + 1));
  check(order.every((/** @type {any} */ g) => index(g, glyphs)) && r >= l && anchors.every((/** @type {any} */ a) => index(a, l, -1) && ends(a))
    && [pushed, own, anchored, gaps].every((part) => part.length === r) && [clusters, names, lines, bases].every((part) => part.length === l)
    && lines.every((/** @type {any} */ line) => index(line, r - l))
    && pushed.flat().every((/** @type {any} */ p) => index(p[0], l) && finite(p[1]))
    && [...own, ...anchored].every(({ x, y }) => form(x) && form(y)), "a row of glyphs");
  return raw;
}

/** @param {any} raw @param {number} axes @param {number} rows @returns {Word["settings"]} */
function settings({ edges, cells }, axes, rows) {
  check(edges.length === axes && edges.flat().every(finite) && cells.every((/** @type {number} */ c) => c >= 0 && c < rows)
    && cells.length === edges.reduce((/** @type {number} */ product, /** @type {any} */ e) => product * (e.length + 1), 1),
  "the settings");
  return { edges, cells };
}

/**
 * @param {any} raw the `_word` trait
 * @returns {Word}
 * @throws {Error} which names what is wrong
 */
export function decodeWord(raw) {
  if (!raw?.rows?.length) throw new Error("there is no word to show");
  const { count, data } = raw.regions, unitsPerEm = raw.units_per_em, axes = raw.axes.map(axis);
  /** @type {Glyph[]} */
  const glyphs = raw.glyphs.map((/** @type {any} */ g) => glyph(g, count));
  /** @type {Row[]} */
  const rows = raw.rows.map((/** @type {any} */ r) => row(r, glyphs.length, count));
  check(finite(unitsPerEm), "units_per_em");
  return {
    family: String(raw.family ?? ""),
    string: String(raw.string ?? ""),
    unitsPerEm,
    ascender: finite(raw.ascender) ? raw.ascender : 0.8 * unitsPerEm,
    descender: finite(raw.descender) ? raw.descender : -0.2 * unitsPerEm,
    axes,
    instances: (raw.instances ?? []).map((/** @type {any} */ { name, axes: values }) => ({ name, axes: complete({ axes }, values) })),
    regions: compile(floats(data, count * axes.length * 3, "the regions"), count, axes.length),
    final: raw.final && node(raw.final),
    kinks: raw.kinks,
    glyphs,
    rows,
    settings: settings(raw.settings, axes.length, rows.length),
    tracking: Number(raw.tracking) || 0,
    offsets: rows[0].order.map((_, i) => [Number(raw.offsets?.[i]?.[0]) || 0, Number(raw.offsets?.[i]?.[1]) || 0]),
  };
}

/** Do two decoded words, or parts of them, say the same? @param {any} a @param {any} b @returns {boolean} */
export function alike(a, b) {
  if (a === b) return true;
  if (a === null || b === null || typeof a !== "object" || typeof b !== "object") return false;
  if (typeof a.length === "number") {
    if (a.length !== b.length) return false;
    for (let i = 0; i < a.length; i++) if (!alike(a[i], b[i])) return false;
    return true;
  }
  return Object.keys({ ...a, ...b }).every((key) => alike(a[key], b[key]));
}

/**
 * Axis values in the shape the `shared` trait asks for, every axis present: values Python and the
 * view may be a message apart, so either shape is read.
 * @param {Word} word @param {any} axes @param {boolean} shared @param {number} selected
 * @returns {Record<string, number> | Record<string, number>[]}
 */
export function conform(word, axes, shared, selected) {
  if (shared) return complete(word, isArray(axes) ? axes[selected] ?? axes[0] : axes);
  return word.rows[0].order.map((_, i) => complete(word, isArray(axes) ? axes[i] : axes));
}

/** @param {Pick<Word, "axes">} word @param {any} values @returns {Record<string, number>} */
export function complete(word, values = {}) {
  check(values !== null && typeof values === "object", "the axes");
  /** @type {Record<string, number>} */
  const out = {};
  for (const axis of word.axes) {
    out[axis.tag] = values[axis.tag] === undefined ? axis.default : values[axis.tag];
    check(finite(out[axis.tag]), `the value of axis ${axis.tag}`);
  }
  return out;
}
