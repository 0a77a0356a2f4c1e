import assert from "node:assert/strict";
import test from "node:test";
import { decodeWord } from "../../src/word/decode.js";
import { coordinates } from "../../src/word/axes.js";
import { Layout } from "../../src/word/forward.js";
import { Positions } from "../../src/word/positions.js";
import { rowAt } from "../../src/word/rows.js";
import { underlines } from "../../src/editor/underline.js";
import { oneRow, rawWord } from "../oil.js";

const nothing = { default: 0, regions: [], deltas: [] };
const step = (value, ...deltas) => ({ x: { default: value, regions: deltas.map((_, j) => j), deltas }, y: nothing });

/** "oil" with a kern between o and i, 40 narrower per weight, and another last letter where it is heavy. */
function kerned() {
  const raw = rawWord(), { rows: [first] } = oneRow([0, 1, 1]), { rows: [second] } = oneRow([0, 1, 0]);
  for (const row of [first, second]) {
    row.own = row.own.map((none, k) => (k === 1 ? step(-10, -20) : none));
    row.anchored = row.anchored.map((none, k) => (k === 1 ? step(-10, -20) : none));
  }
  return { ...raw, offsets: [], rows: [first, second], settings: { edges: [[0.5 + 0.5 / 16384], []], cells: [0, 1] } };
}

test("the row is that of the place, rounded as in OpenType", () => {
  const word = decodeWord({ ...kerned(), settings: { edges: [[-0.5, 0.5], [0]], cells: [0, 1, 1, 0, 0, 1] } });
  const at = (...w) => rowAt(word, w);
  assert.deepEqual([at(-1, -1), at(-1, 1), at(0, -1), at(0, 1), at(1, -1), at(1, 1)], [0, 1, 1, 0, 0, 1]);
});

test("a kern is added once, and another row of glyphs is drawn beyond its boundary", () => {
  const layout = new Layout(decodeWord(kerned()));
  assert.deepEqual([...layout.evaluate({}).x], [0, 580, 880, 1180]);
  assert.deepEqual([...layout.evaluate({ wght: 650 }).x], [0, 600, 920, 1240]);
  assert.equal(layout.points[2].length, 2 * 12);
  assert.deepEqual([...layout.evaluate({ wght: 900 }).x], [0, 620, 960, 1640]);
  assert.equal(layout.points[2].length, 2 * 24);
});

test("between letters with axes of their own a kern is the mean of both places", () => {
  const layout = new Layout(decodeWord(kerned())).evaluate([{ wght: 900 }, {}, {}]);
  assert.deepEqual([...layout.x], [0, 680 - 20 - 20, 680 - 40 + 300, 680 - 40 + 600]);
  assert.deepEqual(layout.row.order, [0, 1, 1]);
  layout.evaluate([{}, {}, { wght: 900 }]);
  assert.deepEqual(layout.row.order, [0, 1, 0]);
});

test("a letter stays with the first row where its own joins letters in another way", () => {
  const raw = kerned();
  raw.rows[1] = oneRow([0, 0]).rows[0];
  const layout = new Layout(decodeWord(raw)).evaluate([{}, {}, { wght: 900 }]);
  assert.deepEqual(layout.row.order, [0, 1, 1]);
  assert.deepEqual(layout.evaluate({ wght: 900 }).row.order, [0, 0]);
});

test("marks hang on letters after them, and tracking skips them", () => {
  const raw = { ...rawWord(), tracking: 9 }, [row] = raw.rows;
  Object.assign(row, {
    bases: [0, 1, 1], anchors: [1, -1, 1, 2], gaps: [0, 0, 1, 2], pushed: [[], [], [[1, 1]], [[1, 1], [2, 1]]],
    own: [step(70), step(5), step(0), step(0)], anchored: [step(0, 30), step(0), step(0), step(0)],
  });
  const layout = new Layout(decodeWord(raw)).evaluate({ wght: 900 });
  assert.deepEqual([...layout.x], [70 + 30 + 5, 5, 5 + 340 + 9, 5 + 680 + 18]);
  assert.deepEqual([...layout.advance], [0, 340, 340]);
});

test("positions follow every row, with shared axes and with axes for each letter", () => {
  const word = decodeWord(kerned()), handles = [[0, 0, 1, 0.3], [1, 0, 2, 0.5], [2, 0, 1, 0.25], 3];
  const places = [{ wght: 700, wdth: 70 }, { wght: 500, wdth: 120 }, { wght: 850, wdth: 90 }];
  for (const axes of [...places, places]) {
    const layout = new Layout(word).evaluate(axes), vectors = [axes].flat();
    const theta = Float64Array.from(vectors.flatMap((values) => [...coordinates(word, values, new Float64Array(2))]));
    const positions = new Positions(word, layout.row, handles, layout.row.order.map((_, i) => (Array.isArray(axes) ? i : 0))).evaluate(theta);
    const expected = [...handles.slice(0, 3).map((handle) => layout.position(handle)), [layout.x[3], layout.y[3]]];
    expected.forEach(([x, y], i) => assert.ok(Math.hypot(positions.x[i] - x, positions.y[i] - y) < 1e-9));
    const before = [...positions.x], slopes = positions.dx.map((row) => row.slice());
    theta.forEach((_, i) => {
      const moved = theta.slice();
      moved[i] += 1e-6;
      positions.evaluate(moved);
      before.forEach((x, p) => assert.ok(Math.abs((positions.x[p] - x) / 1e-6 - slopes[p][i]) < 1e-3));
    });
  }
});

test("malformed rows say what is wrong", () => {
  const broken = (change) => {
    const raw = kerned();
    change(raw);
    return () => decodeWord(raw);
  };
  assert.throws(broken((r) => (r.rows = [])), /no word/);
  for (const change of [
    (row) => (row.anchors = [1, 0, 1, 2]), (row) => (row.anchors = [-1, 0, 5, 2]), (row) => (row.gaps = [0]),
    (row) => (row.pushed[1] = [[9, 1]]), (row) => (row.own[1] = step(0, 1, 2, 3)), (row) => (row.anchored[1] = step(NaN)),
  ]) assert.throws(broken((r) => change(r.rows[0])), /malformed: a row of glyphs/);
  assert.throws(broken((r) => (r.settings.cells = [0])), /malformed: the settings/);
  assert.throws(broken((r) => (r.settings.edges = [[0.5]])), /malformed: the settings/);
});

test("a letter is found on the nearest line, and letters are underlined line by line", () => {
  const raw = rawWord(), row = { ...raw.rows[0], lines: [0, 0, 1], anchors: [-1, 0, -1, 1, 2], gaps: [0, 1, 0, 2, 1] };
  const steps = [0, 0, -1000, 0, -1000].map((y) => ({ x: nothing, y: { ...nothing, default: y } }));
  const pushed = [[], [[0, 1]], [], [[0, 1], [1, 1]], [[2, 1]]], none = steps.map(() => step(0));
  // The step of an end of a line comes after that of its last letter.
  const own = steps.map((one, i) => (i === 4 ? step(0) : one));
  const layout = new Layout(decodeWord({ ...raw, offsets: [], rows: [{ ...row, own, anchored: none, pushed }] })).evaluate({});
  assert.deepEqual([...layout.y], [0, 0, -1000, 0, -1000]);
  assert.deepEqual(layout.ends, [[900, 0], [300, -1000]]);
  assert.equal(layout.letterAt(50, 300), 0);
  assert.equal(layout.letterAt(650, -700), 1);
  assert.equal(layout.letterAt(50, -700), 2);
  assert.equal(layout.letterAt(950, 0), -1);
  assert.deepEqual(underlines(layout, { shared: false, chosen: (letter) => letter >= 1 }).map((line) => line.slice(0, 2)), [[600, 900], [0, 300]]);
  assert.deepEqual(underlines(layout, { shared: true }), []);
});
