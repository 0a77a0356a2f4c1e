import assert from "node:assert/strict";
import test from "node:test";
import { Model } from "../../src/editor/model.js";
import { Session } from "../../src/editor/session.js";
import { rawWord } from "../oil.js";

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

test("a page undoes and redoes by gestures, and goes back to its start", () => {
  const model = new Model({ _word: rawWord(), axes: { wght: 500, wdth: 100 }, shared: true });
  const session = new Session(model, () => {}), heard = [];
  model.on("change:axes", () => heard.push(model.get("axes").wght));
  session.pull(false);
  for (const value of [510, 520]) {
    session.setValues({ wght: value }, "wght");
    session.flush();
  }
  const drag = { type: "drag", view: "v", gesture: "g" };
  model.send({ ...drag, seq: 1, axes: { wght: 600, wdth: 100 } });
  model.send({ ...drag, seq: 2, axes: { wght: 700, wdth: 100 } });
  assert.deepEqual(model.get("_steps"), [2, 0]);
  for (const type of ["undo", "undo", "undo", "redo", "redo", "restart", "undo"]) model.send({ type });
  assert.deepEqual(heard, [520, 500, 520, 700, 500, 700]);
  assert.deepEqual(model.get("_steps"), [2, 1]);
});

test("a drag that ends where it began is no step", () => {
  const axes = { wght: 500, wdth: 100 }, model = new Model({ axes });
  for (const wght of [510, 520, 500]) model.send({ type: "drag", gesture: "g", axes: { ...axes, wght } });
  assert.deepEqual(model.get("_steps"), [0, 0]);
});
