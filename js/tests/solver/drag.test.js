import assert from "node:assert/strict";
import test from "node:test";
import { minimiseInBox } from "../../src/solver/box.js";
import { Drag } from "../../src/solver/drag.js";
import { decodeWord } from "../../src/word/decode.js";
import { Layout } from "../../src/word/forward.js";
import { oneRow, rawWord } from "../oil.js";

const word = decodeWord(rawWord());
const position = (axes, handle) => new Layout(word).evaluate(axes).position(handle);

test("the minimum over a box satisfies its conditions of optimality", () => {
  let seed = 3;
  const next = () => (seed = (seed * 1664525 + 1013904223) % 4294967296) / 4294967296 - 0.5;
  for (let round = 0; round < 200; round++) {
    const n = 1 + (round % 7), m = 1 + (round % 3), c = 10 ** (4 * next());
    const row = () => Float64Array.from({ length: n }, () => 100 * next());
    const model = { residual: Float64Array.from({ length: m }, () => 300 * next()), jacobian: Array.from({ length: m }, row), pull: row() };
    const low = Float64Array.from({ length: n }, () => Math.min(0, 2 * next())), high = Float64Array.from({ length: n }, () => Math.max(0, 2 * next()));
    const d = minimiseInBox(model, c, low, high);
    const f = model.residual.map((v, k) => v + model.jacobian[k].reduce((sum, j, i) => sum + j * d[i], 0));
    d.forEach((v, i) => {
      const slope = model.pull[i] + c * v + model.jacobian.reduce((sum, own, k) => sum + own[i] * f[k], 0);
      assert.ok(v >= low[i] && v <= high[i]);
      if (v > low[i]) assert.ok(slope < 1e-5, `free or at its top: ${slope}`);
      if (v < high[i]) assert.ok(slope > -1e-5, `free or at its bottom: ${slope}`);
    });
  }
});

test("a reachable drag is met, and by the least change of the axes", () => {
  const handle = [1, 0, 1, 0.5], axes = { wght: 400, wdth: 100 };
  const drag = new Drag(word, axes, { handle }), goal = position({ wght: 600, wdth: 100 }, handle);
  const { axes: found, met, held } = drag.to(goal);
  const [x, y] = position(found, handle);
  assert.ok(met && Math.hypot(x - goal[0], y - goal[1]) < 0.5);
  assert.deepEqual(held, []);
});

test("an unreachable drag names the axes that stand in the way", () => {
  const handle = [1, 0, 1, 0.5], drag = new Drag(word, { wght: 400, wdth: 100 }, { handle });
  const { axes, met, missing, held } = drag.to([5000, 350]);
  assert.equal(axes.wght, 900);
  assert.ok(!met && missing > 1000);
  assert.ok(held.some(({ axis, end }) => axis === 0 && end === 1));
});

test("one long step and thirty short ones end at the same place", () => {
  const handle = [0, 0, 0, 0.2], axes = { wght: 500, wdth: 90 }, start = position(axes, handle);
  const one = new Drag(word, axes, { handle }).to([start[0] + 60, start[1] + 9]).axes;
  const drag = new Drag(word, axes, { handle });
  let many = axes;
  for (let i = 1; i <= 30; i++) many = drag.to([start[0] + 2 * i, start[1] + 0.3 * i]).axes;
  for (const { tag, minimum, maximum } of word.axes) assert.ok(Math.abs(one[tag] - many[tag]) < 0.01 * (maximum - minimum), tag);
});

test("locked axes and pins stay, and axes that nothing moves keep their digits", () => {
  const handle = [0, 0, 0, 0.2], axes = { wght: 433.21, wdth: 91.7 }, [x, y] = position(axes, handle);
  const locked = new Drag(word, axes, { handle, locks: ["wght"] }).to([x - 80, y]).axes;
  assert.equal(locked.wght, 433.21);
  assert.notEqual(locked.wdth, 91.7);
  const pin = [0, 1, 1, 0], held = position(axes, pin), [px, py] = position(new Drag(word, axes, { handle, pins: [pin] }).to([x + 40, y]).axes, pin);
  assert.ok(Math.hypot(px - held[0], py - held[1]) < 0.5);
});

test("with axes for each letter, letters after the dragged one stay", () => {
  const handle = [1, 0, 1, 0.5], axes = [{ wght: 400, wdth: 100 }, { wght: 400, wdth: 100 }, { wght: 612.5, wdth: 100 }];
  const [x, y] = position(axes, handle);
  const { axes: found } = new Drag(word, axes, { handle }).to([x + 50, y]);
  assert.deepEqual(found[2], axes[2]);
  assert.notDeepEqual(found[1], axes[1]);
});

test("a drag goes on beyond a boundary with the point carried to the other glyph, and comes back", () => {
  const [first, second] = [[0, 1, 1], [0, 1, 0]].map((order) => oneRow(order).rows[0]);
  const edge = 0.5 + 0.5 / 16384, settings = { edges: [[edge], []], cells: [0, 1] };
  const swapping = decodeWord({ ...rawWord(), offsets: [], rows: [first, second], settings });
  const handle = [2, 0, 1, 0.5], axes = { wght: 400, wdth: 100 }, layout = new Layout(swapping);
  const start = layout.evaluate(axes).position(handle), drag = new Drag(swapping, axes, { handle });
  const inside = drag.to([start[0] + 20, start[1]]);
  assert.ok(inside.met && inside.axes.wght < 650);
  // The right side of the second glyph, a ring, is where the first one never comes.
  const far = layout.evaluate({ wght: 800, wdth: 100 }).position([2, 0, 0, 0]);
  const beyond = drag.to(far), cost = drag.cost;
  assert.ok(beyond.axes.wght > 650);
  assert.equal(layout.evaluate(beyond.axes).row, swapping.rows[1]);
  const confined = new Drag({ ...swapping, settings: { edges: [[], []], cells: [0] } }, axes, { handle, locks: ["wght"] });
  confined.to(far);
  assert.ok(cost < confined.cost);
  const back = drag.to([start[0] + 20, start[1]]);
  assert.ok(back.met && Math.abs(back.axes.wght - inside.axes.wght) < 1);
  assert.deepEqual(back.held, []);
});

test("letters of a range share one axis vector, as a whole word does", () => {
  const handle = [1, 0, 1, 0.5], values = { wght: 450, wdth: 90 }, [x, y] = position(values, handle), goal = [x + 40, y];
  const shared = new Drag(word, values, { handle }).to(goal);
  const all = new Drag(word, [values, values, values], { handle, range: [0, 2] }).to(goal);
  for (const own of all.axes) assert.deepEqual(own, shared.axes);
  const some = new Drag(word, [values, values, values], { handle, range: [1, 2] }).to(goal).axes;
  assert.deepEqual(some[1], some[2]);
  assert.notDeepEqual(some[0], some[1]);
  const { held } = new Drag(word, [values, values, values], { handle, range: [1, 2] }).to([9000, 350]);
  assert.deepEqual([...new Set(held.map(({ letter }) => letter))], [0, 1]);
});

test("a solve that had no time says that it has not finished", () => {
  const handle = [1, 0, 1, 0.5], axes = { wght: 400, wdth: 100 };
  const drag = new Drag(word, axes, { handle }), goal = position({ wght: 600, wdth: 100 }, handle);
  assert.equal(drag.to(goal, 0).finished, false);
  assert.equal(drag.to(goal).finished, true);
});
