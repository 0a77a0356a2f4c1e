import assert from "node:assert/strict";
import test from "node:test";
import { Drag } from "../../src/solver/drag.js";
import { constraintTerm, pin, target } from "../../src/solver/terms.js";
import { decodeWord } from "../../src/word/decode.js";
import { Layout } from "../../src/word/forward.js";
import { rawWord } from "../oil.js";

const places = [[10, 20], [140, 35], [250, -30], [400, 90]];
const of = (kind, count, value) => constraintTerm({ kind, handles: [], value }, [...Array(count).keys()]);

test("the rows of every term have the derivatives of differences", () => {
  const terms = [target(1, [3, 4]), pin(2, [0, 0]), of("SharedX", 3), of("SharedY", 4), of("Collinear", 3), of("Collinear", 4),
    of("Distance", 2, 50), of("Width", 1, 300), of("Width", 3, 200)];
  const step = 1e-5;
  for (const term of terms) {
    const at = (point, c, by) => {
      const [x, y] = [0, 1].map((i) => Float64Array.from(places, (p) => p[i]));
      [x, y][c][point] += by;
      return term.rows(x, y);
    };
    const rows = at(0, 0, 0);
    rows.forEach(({ by }, k) => {
      for (let point = 0; point < places.length; point++) {
        [0, 1].forEach((c) => {
          const difference = (at(point, c, step)[k].value - at(point, c, -step)[k].value) / (2 * step);
          const given = by.filter(([p]) => p === point).reduce((sum, entry) => sum + entry[1 + c], 0);
          assert.ok(Math.abs(difference - given) < 1e-6, `row ${k}, point ${point}, coordinate ${c}`);
        });
      }
    });
  }
});

const word = decodeWord(rawWord()), start = { wght: 500, wdth: 90 };
const layoutAt = (axes) => new Layout(word).evaluate(axes);

test("constraints are met without a target, and kept in a drag", () => {
  const stem = [[1, 0, 1, 0.5], [1, 0, 3, 0.5]];
  const size = (axes) => {
    const [a, b] = stem.map((handle) => layoutAt(axes).position(handle));
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  const constraints = [{ kind: "Distance", handles: stem, value: 160 }];
  const met = new Drag(word, start, { constraints }).to(null);
  assert.ok(met.met && Math.abs(size(met.axes) - 160) < 0.1);
  const handle = [0, 0, 0, 0.2], [x, y] = layoutAt(met.axes).position(handle);
  const dragged = new Drag(word, met.axes, { handle, constraints }).to([x - 70, y]).axes;
  assert.ok(Math.abs(size(dragged) - 160) < 0.1);
  assert.ok(layoutAt(dragged).position(handle)[0] < x - 60);
  const width = new Drag(word, start, { constraints: [...constraints, { kind: "Width", handles: [], value: 1100 }] }).to(null);
  assert.ok(width.met && Math.abs(layoutAt(width.axes).ends[0][0] - 1100) < 0.1);
});

test("constraints that exclude each other are as near as they can be, and said to be missed", () => {
  const constraints = [{ kind: "Width", handles: [], value: 1000 }, { kind: "Width", handles: [], value: 1200 }];
  const { axes, met, missing } = new Drag(word, start, { constraints }).to(null);
  assert.ok(!met && Math.abs(missing - 100) < 1);
  assert.ok(Math.abs(layoutAt(axes).ends[0][0] - 1100) < 1);
});
