/**
 * Reads the word a kernel (or an exported page) hands over: JSON with binary buffers in, typed
 * arrays out, everything checked once so that the drawing loop need not.
 */
import { compile } from "./forward.js";

/** @typedef {import("./rows.js").Row} Row */
/**
 * @typedef {{tag: string, name: string, minimum: number, default: number, maximum: number,
 *   hidden: boolean, map: [number, number][]}} Axis
 * @typedef {{name: string, contours: number[], starts: number[], k: number, points: Float32Array,
 *   regions: number[], advance: {default: number, regions: number[], deltas: number[]}}} Glyph
 *   `starts`: a contour's first point; region scalars times deltas move points and advance
 * @typedef {{family: string, string: string, unitsPerEm: number, ascender: number, descender: number,
 *   instances: {name: string, axes: Record<string, number>}[], axes: Axis[], regions: import("./forward.js").Regions,
 *   glyphs: Glyph[], rows: Row[], settings: {edges: number[][], cells: number[]}, tracking: number,
 *   offsets: [number, number][]}} Word
 */

/** @param {boolean} condition @param {string} message */
function check(condition, message) {
  if (!condition) throw new Error(message);
}

const finite = (/** @type {unknown} */ v) => typeof v === "number" && Number.isFinite(v);

/** @param {any} value @param {string} what @returns {number} */
function number(value, what) {
  check(finite(value), `${what} is not a number`);
  return value;
}

/** @param {any} value @param {string} what @returns {any[]} */
function list(value, what) {
  check(Array.isArray(value), `${what} is not a list`);
  return value;
}

/**
 * Little-endian float32 numbers from whatever carries them; base64 because JSON (an exported page)
 * has no bytes. Copied, since a comm buffer may start at any byte.
 * @param {any} data @param {number} length @param {string} what
 */
function floats(data, length, what) {
  if (length === 0) return new Float32Array(0);
  if (typeof data === "string") data = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
  const bytes = ArrayBuffer.isView(data)
    ? new DataView(data.buffer, data.byteOffset, data.byteLength)
    : data instanceof ArrayBuffer ? new DataView(data) : null;
  if (bytes === null) throw new Error(`${what} has no binary data`);
  check(bytes.byteLength === 4 * length,
    `${what} needs ${length} numbers and brings ${bytes.byteLength / 4}`);
  const out = new Float32Array(length);
  for (let i = 0; i < length; i++) out[i] = bytes.getFloat32(4 * i, true);
  return out;
}

/** @param {any} raw @returns {Axis} */
function axis(raw) {
  const tag = String(raw.tag);
  const [minimum, normal, maximum] = [raw.minimum, raw.default, raw.maximum]
    .map((v) => number(v, `a limit of axis ${tag}`));
  check(minimum <= normal && normal <= maximum, `the limits of axis ${tag} are out of order`);
  const map = raw.map?.length ? list(raw.map, `the map of axis ${tag}`) : [[-1, -1], [0, 0], [1, 1]];
  check(map.every((p, i) => finite(p?.[0]) && finite(p[1]) && (i === 0 || map[i - 1][0] <= p[0])),
    `the map of axis ${tag} is malformed`);
  const name = String(raw.name || tag);
  return { tag, name, minimum, default: normal, maximum, hidden: Boolean(raw.hidden), map };
}

/** @param {any} raw @param {number} count @returns {Glyph} */
function glyph(raw, count) {
  const name = String(raw.name);
  const contours = list(raw.contours, `contours of glyph ${name}`);
  check(contours.every((s) => Number.isInteger(s) && s >= 0), `contours of glyph ${name} are malformed`);
  const starts = [];
  let k = 0;
  for (const s of contours) {
    starts.push(k);
    k += 3 * s;
  }
  const indices = (/** @type {any} */ value) => {
    const regions = list(value, `regions of glyph ${name}`);
    check(regions.every((r) => r >= 0 && r < count), `glyph ${name} names a region that is not there`);
    return regions;
  };
  const regions = indices(raw.regions);
  const points = floats(raw.points, 2 * k * (1 + regions.length), `glyph ${name}`);
  const advance = {
    default: number(raw.advance?.default, `the advance of glyph ${name}`),
    regions: indices(raw.advance.regions),
    deltas: list(raw.advance.deltas, `the advance deltas of glyph ${name}`),
  };
  check(advance.deltas.length === advance.regions.length && advance.deltas.every(finite),
    `the advance deltas of glyph ${name} are malformed`);
  return { name, contours, starts, k, points, regions, advance };
}

/** @param {any} raw @param {number} glyphs how many there are @param {number} count of regions @returns {Row} */
function row(raw, glyphs, count) {
  const index = (/** @type {any} */ v, /** @type {number} */ length, low = 0) => Number.isInteger(v) && v >= low && v < length;
  const form = (/** @type {any} */ f) => finite(f.default) && f.regions.length === f.deltas.length && f.deltas.every(finite)
    && f.regions.every((/** @type {any} */ r) => index(r, count));
  const { order, anchors, pushed, own, beside, gaps, clusters, bases } = raw, l = order.length, r = anchors.length;
  check(order.every((/** @type {any} */ g) => index(g, glyphs)), "the word names a glyph that is not there");
  // A chain of anchors that returned to its start would have no end.
  const ends = (/** @type {number} */ i, steps = 0) => i < 0 || (index(i, r) && steps < r && ends(anchors[i], steps + 1));
  check(r >= l && anchors.every((/** @type {any} */ a) => index(a, l, -1) && ends(a))
    && [pushed, own, beside, gaps].every((part) => part.length === r) && clusters.length === l && bases.length === l
    && pushed.flat().every((/** @type {any} */ p) => index(p[0], l) && finite(p[1]))
    && [...own, ...beside].every(({ x, y }) => form(x) && form(y)), "a row of glyphs is malformed");
  return raw;
}

/** @param {any} raw @param {number} axes @param {number} rows @returns {Word["settings"]} */
function settings({ edges, cells }, axes, rows) {
  check(edges.length === axes && edges.flat().every(finite) && cells.every((/** @type {number} */ c) => c >= 0 && c < rows)
    && cells.length === edges.reduce((/** @type {number} */ product, /** @type {any} */ e) => product * (e.length + 1), 1),
  "the settings are malformed");
  return { edges, cells };
}

/**
 * @param {any} raw the `_word` trait
 * @returns {Word}
 * @throws {Error} which names what is wrong
 */
export function decodeWord(raw) {
  check(raw !== null && typeof raw === "object" && Array.isArray(raw.rows), "there is no word to show");
  const count = number(raw.regions?.count, "the number of regions");
  const axes = list(raw.axes, "axes").map(axis);
  const data = floats(raw.regions.data, count * axes.length * 3, "regions");
  const glyphs = list(raw.glyphs, "glyphs").map((g) => glyph(g, count));
  const rows = list(raw.rows, "rows").map((r) => row(r, glyphs.length, count));
  check(rows.length > 0, "there is no word to show");
  const unitsPerEm = number(raw.units_per_em, "units_per_em");
  return {
    family: String(raw.family ?? ""),
    string: String(raw.string ?? ""),
    unitsPerEm,
    ascender: finite(raw.ascender) ? raw.ascender : 0.8 * unitsPerEm,
    descender: finite(raw.descender) ? raw.descender : -0.2 * unitsPerEm,
    axes,
    instances: list(raw.instances ?? [], "instances").map((instance) => (
      { name: String(instance?.name), axes: complete({ axes }, instance?.axes) })),
    regions: compile(data, count, axes.length),
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
  if (shared) return complete(word, Array.isArray(axes) ? axes[selected] ?? axes[0] : axes);
  return word.rows[0].order.map((_, i) => complete(word, Array.isArray(axes) ? axes[i] : axes));
}

/** @param {Pick<Word, "axes">} word @param {any} values @returns {Record<string, number>} */
export function complete(word, values = {}) {
  check(values !== null && typeof values === "object", "axes are neither an object nor a list of objects");
  /** @type {Record<string, number>} */
  const out = {};
  for (const axis of word.axes) {
    out[axis.tag] = values[axis.tag] === undefined
      ? axis.default : number(values[axis.tag], `the value of axis ${axis.tag}`);
  }
  return out;
}
