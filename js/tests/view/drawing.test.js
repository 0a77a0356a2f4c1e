import assert from "node:assert/strict";
import test from "node:test";
import { windowFor } from "../../src/view/drawing.js";
import { pathData } from "../../src/view/path.js";
import { Layout } from "../../src/word/forward.js";
import { decodeWord } from "../../src/word/decode.js";
import { oneRow, rawWord } from "../oil.js";

test("path data: closed contours of cubics, y down, relative to the letter's origin", () => {
  const layout = new Layout(decodeWord(rawWord())).evaluate({});
  const stem = pathData(layout, 1);
  assert.equal(stem, pathData(layout, 2));
  assert.match(stem, /^M100 0C133\.3 0 166\.7 0 200 0C200 -233\.3 /);
  assert.match(stem, / 100 0Z$/);
  assert.equal(pathData(layout, 0).match(/M/g).length, 2);
  assert.equal(pathData(layout, 0).match(/C/g).length, 8);
});

test("a glyph without an outline draws nothing and keeps its place", () => {
  const raw = rawWord();
  raw.glyphs.push({ name: "space", contours: [], points: null, regions: [], advance: { default: 250, regions: [], deltas: [] } });
  Object.assign(raw, oneRow([2, 1]));
  raw.offsets = [];
  const layout = new Layout(decodeWord(raw)).evaluate({});
  assert.equal(pathData(layout, 0), "");
  assert.deepEqual([...layout.x], [0, 250, 550]);
});

test("the window holds the word, ascender and descender with room around them", () => {
  const layout = new Layout(decodeWord(rawWord())).evaluate({});
  const { x, y, width, height } = windowFor(layout);
  const [left, bottom, right, top] = layout.box();
  assert.deepEqual([left, bottom, right, top], [0, -10, 1200, 710]);
  assert.ok(x < left && x + width > right && y < -800 && y + height > 200);
  const empty = windowFor(new Layout(decodeWord({ ...rawWord(), ...oneRow([]) })).evaluate({}));
  assert.ok(empty.width > 0 && empty.height > 0);
});
