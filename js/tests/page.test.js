import assert from "node:assert/strict";
import test from "node:test";
import { Model } from "../src/page.js";
import { Session } from "../src/editor/session.js";
import { rawWord } from "./oil.js";

test("a page's model keeps what the view writes", () => {
  const model = new Model({ _word: rawWord(), axes: { wght: 500 }, shared: true });
  const session = new Session(model, () => {});
  session.pull(false);
  assert.deepEqual([session.pins, session.error, session.problems.size], [[], "", 0]);
  session.setValues({ wght: 700 });
  session.flush();
  session.expire("axes");
  session.pull(false);
  assert.deepEqual(session.axes, { wght: 700, wdth: 100 });
  session.setShared(false);
  session.flush();
  assert.deepEqual([model.get("shared"), model.get("axes").length], [false, 3]);
});

test("a word in base64, as JSON carries it, is the word in bytes", () => {
  const base64 = (view) => Buffer.from(view.buffer).toString("base64");
  const raw = rawWord();
  raw.regions.data = base64(raw.regions.data);
  for (const glyph of raw.glyphs) glyph.points = base64(glyph.points);
  const read = (word) => {
    const session = new Session(new Model(JSON.parse(JSON.stringify({ _word: word, axes: {} }))), () => {});
    session.pull(false);
    return session.word;
  };
  const bytes = new Session(new Model({ _word: rawWord(), axes: {} }), () => {});
  bytes.pull(false);
  assert.deepEqual(read(raw), bytes.word);
});
