import assert from "node:assert/strict";
import test from "node:test";
import { cubic, nearest, nearestOnCubic } from "../../src/word/cubics.js";
import { Layout } from "../../src/word/forward.js";
import { decodeWord } from "../../src/word/decode.js";
import { oneRow, rawWord } from "../oil.js";

/** The same numbers every run. */
function random(seed) {
  return () => {
    seed = (seed * 1664525 + 1013904223) % 4294967296;
    return seed / 4294967296;
  };
}

const distance = (p, t, x, y) => Math.hypot(cubic(p[0], p[2], p[4], p[6], t) - x, cubic(p[1], p[3], p[5], p[7], t) - y);

function brute(p, x, y, n = 4000) {
  let best = Infinity;
  for (let i = 0; i <= n; i++) best = Math.min(best, distance(p, i / n, x, y));
  return best;
}

test("nearest on a cubic is never worse than brute force", () => {
  const next = random(7);
  for (let i = 0; i < 400; i++) {
    const p = Float64Array.from({ length: 8 }, () => 1000 * next());
    const x = 1400 * next() - 200, y = 1400 * next() - 200;
    const { t, d2 } = nearestOnCubic(p, x, y);
    assert.ok(t >= 0 && t <= 1);
    assert.ok(Math.abs(Math.sqrt(d2) - distance(p, t, x, y)) < 1e-9);
    assert.ok(Math.sqrt(d2) <= brute(p, x, y) + 1e-9, `cubic ${[...p]} from ${x}, ${y}`);
  }
});

test("nearest on lines, points, cusps and folded cubics", () => {
  const shapes = {
    line: [0, 0, 100, 0, 200, 0, 300, 0],
    "line with its handles on the ends": [0, 0, 0, 0, 300, 0, 300, 0],
    point: [50, 50, 50, 50, 50, 50, 50, 50],
    cusp: [0, 0, 300, 200, 0, 200, 300, 0],
    folded: [0, 0, 300, 0, -200, 0, 100, 0],
    "retracted handle": [0, 0, 0, 0, 100, 300, 300, 0],
    loop: [0, 0, 400, 300, -100, 300, 300, 0],
  };
  for (const [name, values] of Object.entries(shapes)) {
    const p = Float64Array.from(values);
    for (const [x, y] of [[-40, 10], [0, 0], [150, 0], [150, 90], [150, 1000], [310, -5], [50, 50]]) {
      const { t, d2 } = nearestOnCubic(p, x, y);
      assert.ok(t >= 0 && t <= 1 && Number.isFinite(d2), name);
      assert.ok(Math.sqrt(d2) <= brute(p, x, y) + 1e-6, `${name} from ${x}, ${y}: ${Math.sqrt(d2)}`);
    }
  }
  assert.ok(Math.abs(nearestOnCubic(Float64Array.from(shapes.line), 150, 20).t - 0.5) < 1e-9);
});

test("nearest on a word agrees with brute force over every segment", () => {
  const layout = new Layout(decodeWord(rawWord())).evaluate({ wght: 700, wdth: 80 });
  const next = random(11);
  for (let i = 0; i < 60; i++) {
    const x = 1700 * next() - 200, y = 1200 * next() - 200;
    const found = nearest(layout, x, y);
    let best = Infinity;
    layout.glyphs.forEach(({ contours }, glyph) => contours.forEach((count, contour) => {
      for (let segment = 0; segment < count; segment++) {
        for (let j = 0; j <= 1000; j++) {
          const [px, py] = layout.position([glyph, contour, segment, j / 1000]);
          best = Math.min(best, Math.hypot(px - x, py - y));
        }
      }
    }));
    assert.ok(found.distance <= best + 1e-9 && found.distance > best - 1, `${x}, ${y}`);
    assert.ok(Math.abs(Math.hypot(found.x - x, found.y - y) - found.distance) < 1e-6);
    assert.deepEqual(layout.position([found.glyph, found.contour, found.segment, found.t]), [found.x, found.y]);
  }
});

test("nearest: reach, corners, an empty word", () => {
  const layout = new Layout(decodeWord(rawWord())).evaluate({});
  assert.equal(nearest(layout, 300, 350, 24), null); // the counter of the o
  const corner = nearest(layout, 800 + 5, -5, 24);
  assert.deepEqual([corner.glyph, corner.contour, corner.segment, corner.t], [1, 0, 1, 0]);
  const closing = nearest(layout, 700 - 5, -5, 24);
  assert.deepEqual([closing.glyph, closing.contour, closing.segment, closing.t], [1, 0, 0, 0]);
  assert.equal(nearest(new Layout(decodeWord({ ...rawWord(), ...oneRow([]) })).evaluate({}), 0, 0), null);
});
