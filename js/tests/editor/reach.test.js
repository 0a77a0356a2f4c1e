import assert from "node:assert/strict";
import test from "node:test";
import { Reach } from "../../src/editor/reach.js";
import { Drag } from "../../src/solver/drag.js";
import { decodeWord } from "../../src/word/decode.js";
import { Layout } from "../../src/word/forward.js";
import { rawWord } from "../oil.js";

const word = decodeWord(rawWord()), handle = [0, 0, 0, 0.2], home = { wght: 400, wdth: 100 }, SPACING = 8;
const position = (axes) => new Layout(word).evaluate(axes).position(handle);

/** The places found, when there is nothing more to do. */
function places(wishes, spacing = SPACING) {
  const reach = new Reach(new Drag(word, home, { handle, ...wishes }), position(home), spacing);
  let rounds = 0;
  while (reach.grow(5)) assert.ok(++rounds < 2000);
  return [...reach.path.matchAll(/M(\S+) (\S+)h0/g)].map(([, x, y]) => [Number(x), -Number(y)]);
}

const distance = (found, [x, y]) => Math.min(...found.map(([a, b]) => Math.hypot(a - x, b - y)));

test("every place that some axis values give is near one that was found", () => {
  const found = places({});
  for (let i = 0; i <= 20; i++) {
    for (let j = 0; j <= 20; j++) {
      const at = position({ wght: 100 + 40 * i, wdth: 50 + 5 * j });
      assert.ok(distance(found, at) < 1.5 * SPACING, `${at}`);
    }
  }
});

test("locks and pins make it smaller", () => {
  const all = places({}), locked = places({ locks: ["wdth"] });
  assert.ok(locked.length < all.length);
  const line = Array.from({ length: 101 }, (_, i) => position({ wght: 100 + 8 * i, wdth: 100 }));
  for (const at of locked) assert.ok(distance(line, at) < 2, `${at}`);
  assert.ok(places({ locks: ["wdth", "wght"] }).every((at) => distance([position(home)], at) < 0.1));
  assert.ok(places({ pins: [[0, 0, 0, 0.2]] }).every((at) => distance([position(home)], at) < 0.5));
});

test("a grid that is too fine ends all the same", () => {
  assert.ok(places({}, 0.05).length <= 8000);
});
