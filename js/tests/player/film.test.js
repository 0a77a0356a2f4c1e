import assert from "node:assert/strict";
import test from "node:test";
import { advanced, decodeFilm, frameAt, stateAt, varying } from "../../src/player/film.js";
import { decodeWord } from "../../src/word/decode.js";
import { floats, rawWord } from "../oil.js";

const word = decodeWord(rawWord());

/** Three frames, shared axes: the weight rises, the second letter too, and turns. */
const raw = (changes = {}) => ({
  times: [0, 0.5, 2], vector_count: 1, letter_count: 3, box: [0, -200, 1000, 800],
  axes: floats([400, 100, 500, 100, 900, 100]),
  offsets: floats([0, 0, 0, 0, 0, 0, /**/ 0, 0, 10, 20, 0, 0, /**/ 0, 0, 10, 50, 0, 0]),
  rotations: floats([0, 0, 0, 0, 1, 0, 0, 2, 0]),
  obstacles: ["M0 0", "M1 1"], scene: [0, 0, 1], ...changes,
});

test("between two frames everything is interpolated", () => {
  const film = decodeFilm(raw(), word);
  assert.deepEqual(stateAt(film, word, 0.25), {
    frame: 0, axes: { wght: 450, wdth: 100 }, offsets: [[0, 0], [5, 10], [0, 0]], rotations: [0, 0.5, 0],
  });
  assert.deepEqual(stateAt(film, word, 2).axes, { wght: 900, wdth: 100 });
  assert.deepEqual(stateAt(film, word, 1.25).offsets[1], [10, 35]);
});

test("letters may have axes of their own", () => {
  const axes = floats([400, 100, 500, 100, 600, 100, 900, 100, 500, 100, 600, 100]);
  const two = { times: [0, 1], vector_count: 3, axes, offsets: floats(Array(12).fill(0)), rotations: floats(Array(6).fill(0)), scene: [] };
  const film = decodeFilm(raw(two), word);
  assert.deepEqual(stateAt(film, word, 0.5).axes, [{ wght: 650, wdth: 100 }, { wght: 500, wdth: 100 }, { wght: 600, wdth: 100 }]);
  assert.deepEqual(varying(film, word), [0]);
});

test("the frame at a time is the last one that has begun", () => {
  const film = decodeFilm(raw(), word);
  assert.deepEqual([0, 0.4, 0.5, 1.9, 2, 9].map((time) => frameAt(film, time)), [0, 0, 1, 1, 2, 2]);
});

test("a clock starts again or stays at the end", () => {
  assert.deepEqual(advanced(1, 2, true), { time: 1, ended: false });
  assert.deepEqual(advanced(5, 2, true), { time: 1, ended: false });
  assert.deepEqual(advanced(5, 2, false), { time: 2, ended: true });
  assert.deepEqual(advanced(0.1, 0, true), { time: 0, ended: true });
});

test("malformed frames are refused with a reason", () => {
  for (const [changes, reason] of [
    [{ times: [] }, /no animation/], [{ times: [0, 1, 1] }, /increase/], [{ letter_count: 0 }, /letters/],
    [{ box: [0, 0, 0, 1] }, /box/], [{ scene: [0, 2] }, /obstacles/], [{ axes: floats([1]) }, /malformed: axes/],
  ]) assert.throws(() => decodeFilm(raw(changes), word), reason);
  assert.throws(() => decodeFilm(null, word), /no animation/);
});
