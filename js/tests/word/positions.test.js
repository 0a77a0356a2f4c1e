import assert from "node:assert/strict";
import test from "node:test";
import { decodeWord } from "../../src/word/decode.js";
import { coordinates, denormalize, normalize } from "../../src/word/axes.js";
import { Layout } from "../../src/word/forward.js";
import { Positions } from "../../src/word/positions.js";
import { rawWord } from "../oil.js";

const handles = [[0, 0, 1, 0.3], [0, 1, 3, 1], [1, 0, 2, 0.5], [2, 0, 1, 0.25]];
const places = [{ wght: 410, wdth: 99 }, { wght: 700, wdth: 70 }, { wght: 300, wdth: 120 }];

/** The flat coordinates of shared axes, or of one set for each letter. */
function flat(word, axes) {
  return Float64Array.from([axes].flat().flatMap((values) => [...coordinates(word, values, new Float64Array(word.axes.length))]));
}

/** The axis vector of each letter. */
const owners = (word, axes) => word.rows[0].order.map((_, i) => (Array.isArray(axes) ? i : 0));

test("positions are those of the layout, with shared axes and with axes for each letter", () => {
  const word = decodeWord(rawWord());
  for (const axes of [...places, places]) {
    const layout = new Layout(word).evaluate(axes);
    const { x, y } = new Positions(word, word.rows[0], [...handles, 3], owners(word, axes)).evaluate(flat(word, axes));
    handles.forEach((handle, i) => {
      const [px, py] = layout.position(handle);
      assert.ok(Math.abs(x[i] - px) < 1e-9 && Math.abs(y[i] - py) < 1e-9);
    });
    assert.ok(Math.abs(x[4] - (layout.x[1] + layout.advance[1] + layout.advance[2])) < 1e-9);
  }
});

test("derivatives are those of differences", () => {
  const word = decodeWord(rawWord()), step = 1e-6;
  for (const axes of [...places, places]) {
    const positions = new Positions(word, word.rows[0], [...handles, 3], owners(word, axes)), theta = flat(word, axes);
    const at = (i, by) => {
      const moved = theta.slice();
      moved[i] += by;
      const { x, y } = positions.evaluate(moved);
      return [[...x], [...y]];
    };
    theta.forEach((_, i) => {
      const [left, right] = [at(i, -step), at(i, step)];
      positions.evaluate(theta);
      [positions.dx, positions.dy].forEach((rows, c) => rows.forEach((row, p) => {
        assert.ok(Math.abs(row[i] - (right[c][p] - left[c][p]) / (2 * step)) < 1e-5, `coordinate ${c} of point ${p} by ${i}`);
      }));
    });
  }
});

test("an advance below zero pushes nothing", () => {
  const raw = rawWord();
  raw.glyphs[0].advance.deltas = [0, -5000];
  const word = decodeWord(raw), positions = new Positions(word, word.rows[0], [[1, 0, 0, 0]], owners(word, {})).evaluate(Float64Array.of(0, -1));
  assert.equal(positions.x[0], 100);
  assert.deepEqual([...positions.dx[0]], [0, 0]);
});

test("kinks are those of the regions that move the points", () => {
  const word = decodeWord(rawWord());
  assert.deepEqual(new Positions(word, word.rows[0], [[0, 0, 0, 0]], owners(word, {})).kinks(), [[0, 1], [-1, 0]]);
  // The i by itself does not depend on the width, but the o before it does.
  assert.deepEqual(new Positions(word, word.rows[0], [[1, 0, 0, 0]], owners(word, {})).kinks(), [[0, 1], [-1, 0]]);
});

test("denormalize undoes normalize, on bent, flat and one-sided axes", () => {
  const axes = [
    { minimum: 100, default: 400, maximum: 900, map: [[-1, -1], [-0.5, -0.7], [0, 0], [0.25, 0.5], [1, 1]] },
    { minimum: 0, default: 0, maximum: 1, map: [[-1, -1], [0, 0], [1, 1]] },
    { minimum: -15, default: 0, maximum: 0, map: [[-1, -1], [0, 0], [1, 1]] },
  ];
  for (const axis of axes) {
    for (let i = 0; i <= 20; i++) {
      const user = axis.minimum + (i / 20) * (axis.maximum - axis.minimum);
      assert.ok(Math.abs(denormalize(axis, normalize(axis, user)) - user) < 1e-9, `${user}`);
    }
  }
  const flat = { minimum: 0, default: 0, maximum: 10, map: [[-1, -1], [0, 0], [0.5, 0.4], [0.8, 0.4], [1, 1]] };
  assert.equal(denormalize(flat, 0.4), 5);
});
