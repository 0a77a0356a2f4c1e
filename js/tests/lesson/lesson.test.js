import assert from "node:assert/strict";
import test from "node:test";
import { axisEffect } from "../../src/lesson/lesson.js";
import { decodeWord } from "../../src/word/decode.js";
import { rawWord } from "../oil.js";

test("the effect of an axis is the greatest displacement over its range", () => {
  const word = decodeWord(rawWord());
  word.glyphs.forEach((glyph) => {
    const { k, points } = glyph;
    // Each region of this word has one axis, and its scalar is 1 at one end of it.
    const most = glyph.regions.map((_, j) => {
      let far = 0;
      for (let p = 0; p < k; p++) far = Math.max(far, Math.hypot(points[2 * (k * (j + 1) + p)], points[2 * (k * (j + 1) + p) + 1]));
      return far;
    });
    const expected = [0, 1].map((region) => most[glyph.regions.indexOf(region)] ?? 0);
    axisEffect(word, glyph).forEach((effect, i) => assert.ok(Math.abs(effect - expected[i]) < 1e-3, `${effect} ${expected[i]}`));
  });
});
