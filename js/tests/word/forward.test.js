import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import { normalize } from "../../src/word/axes.js";
import { interpolate, Layout } from "../../src/word/forward.js";
import { compile, scalars } from "../../src/word/regions.js";
import { complete, conform, decodeWord } from "../../src/word/decode.js";
import { floats, rawWord } from "../oil.js";

const cases = JSON.parse(readFileSync(new URL("../cases.json", import.meta.url), "utf8"));

const close = (got, want, name, tolerance = 1e-12) => {
  assert.equal(got.length, want.length, name);
  want.forEach((v, i) => assert.ok(Math.abs(got[i] - v) <= tolerance, `${name}: ${got[i]} is not ${v}`));
};

test("scalars, by hand", () => {
  for (const { name, support, w, scalars: want } of cases.scalars) {
    const regions = compile(support.flat(2), support.length, w.length);
    close(scalars(regions, w, new Float64Array(support.length)), want, name);
  }
});

test("normalization, by hand", () => {
  for (const { name, axis, map, user, normalized } of cases.normalization) {
    close([normalize({ ...axis, map }, user)], [normalized], name);
  }
});

test("points, by hand", () => {
  for (const { name, default: normal, deltas, support, w, points } of cases.points) {
    const regions = compile(support.flat(2), support.length, w.length);
    const gamma = scalars(regions, w, new Float64Array(support.length));
    const glyph = { k: normal.length, points: Float32Array.from([normal, ...deltas].flat(2)), regions: deltas.map((_, j) => j) };
    close(interpolate(glyph, gamma, new Float64Array(2 * normal.length)), points.flat(), name);
  }
});

test("a word: origins from advances and offsets, shared axes", () => {
  const word = decodeWord(rawWord());
  const layout = new Layout(word).evaluate({ wght: 650, wdth: 75 });
  close([...layout.places[0]], [0.5, -0.5], "coordinates");
  close([...layout.gammas[0]], [0.5, 0.5], "scalars");
  // "oil": the o (600 + 0.5 · 80 − 0.5 · 200), the i (300 + 0.5 · 40), and the last letter 7 up; then the end.
  close([...layout.x], [0, 540, 860, 1180], "x");
  close([...layout.y], [0, 0, 7, 0], "y");
  close([...layout.points[2]], [...layout.points[1]], "two letters of one glyph");
});

test("a word: axes for each letter", () => {
  const layout = new Layout(decodeWord(rawWord())).evaluate([{ wght: 900 }, {}, { wght: 650, wdth: 75 }]);
  close([...layout.x], [0, 680, 980, 1300], "x");
  assert.notDeepEqual(layout.points[1], layout.points[2]);
  const again = new Layout(decodeWord(rawWord())).evaluate({ wght: 650, wdth: 75 });
  close([...layout.points[2]], [...again.points[2]], "the letter by itself and with the others");
});

test("a handle's place, also on the segment that closes a contour", () => {
  const layout = new Layout(decodeWord(rawWord())).evaluate({});
  close(layout.position([1, 0, 0, 0]), [600 + 100, 0], "start");
  close(layout.position([1, 0, 3, 1]), [600 + 100, 0], "end of the last segment");
  close(layout.position([1, 0, 1, 0.5]), [600 + 200, 350], "middle of the right stem", 1e-4);
  for (const bad of [null, [], [3, 0, 0, 0], [0, 2, 0, 0], [0, 0, 9, 0], [0, 0, 0.5, 0], [0, 0, 0, 2], ["a", 0, 0, 0]]) {
    assert.equal(layout.has(bad), false, JSON.stringify(bad));
  }
  assert.ok(layout.has([0, 1, 3, 1]));
});

test("an advance is never negative", () => {
  const raw = rawWord();
  raw.glyphs[0].advance.deltas = [0, -5000];
  assert.deepEqual([...new Layout(decodeWord(raw)).evaluate({ wdth: 50 }).x], [0, 0, 300, 600]);
});

test("a coordinate within rounding of a peak that is also an end counts as on it", () => {
  const regions = compile([0, 0.5, 0.5, 0.5, 0.5, 1], 2, 1);
  close(scalars(regions, [0.5 + 1e-12], new Float64Array(2)), [1, 1], "above", 1e-9);
  close(scalars(regions, [0.5 - 1e-12], new Float64Array(2)), [1, 1], "below", 1e-9);
});

test("buffers: any view, any alignment, base64", () => {
  const raw = rawWord(), want = decodeWord(raw).glyphs[0].points;
  const bytes = new Uint8Array(raw.glyphs[0].points.buffer);
  const shifted = new Uint8Array(bytes.length + 3);
  shifted.set(bytes, 3);
  for (const points of [bytes.buffer, bytes, new DataView(shifted.buffer, 3), Buffer.from(bytes).toString("base64")]) {
    raw.glyphs[0].points = points;
    assert.deepEqual(decodeWord(raw).glyphs[0].points, want);
  }
});

test("a malformed word says what is wrong", () => {
  const broken = (change) => {
    const raw = rawWord();
    change(raw);
    return () => decodeWord(raw);
  };
  assert.throws(() => decodeWord(null), /no word/);
  assert.throws(() => decodeWord({}), /no word/);
  assert.throws(broken((r) => (r.glyphs[0].points = floats([1, 2]))), /glyph o/);
  assert.throws(broken((r) => (r.glyphs[1].points = null)), /glyph il/);
  assert.throws(broken((r) => (r.glyphs[0].regions = [0, 9])), /glyph o/);
  assert.throws(broken((r) => (r.rows[0].order = [0, 5, 1])), /row of glyphs/);
  assert.throws(broken((r) => (r.axes[0].default = 20)), /axis wght/);
  assert.throws(broken((r) => (r.axes[0].maximum = NaN)), /axis wght/);
  assert.throws(broken((r) => (r.axes[0].map = [[0, 0], [-1, 1]])), /axis wght/);
  assert.throws(broken((r) => delete r.regions), /regions/);
});

test("axes: either shape is read, what is missing is the default, nonsense is refused", () => {
  const word = decodeWord(rawWord()), full = { wght: 400, wdth: 100 };
  assert.deepEqual(complete(word, { wght: 500, XXXX: 3 }), { wght: 500, wdth: 100 });
  assert.deepEqual(conform(word, undefined, true, 0), full);
  assert.deepEqual(conform(word, [{ wght: 1 }, { wght: 2 }], true, 1), { wght: 2, wdth: 100 });
  assert.deepEqual(conform(word, { wght: 7 }, false, 0), [1, 2, 3].map(() => ({ wght: 7, wdth: 100 })));
  assert.deepEqual(conform(word, [{ wght: 1 }], false, 0), [{ wght: 1, wdth: 100 }, full, full]);
  for (const bad of [null, "wght", 5]) assert.throws(() => conform(word, bad, true, 0));
  assert.throws(() => conform(word, { wght: null }, true, 0), /value of axis wght/);
});
