import assert from "node:assert/strict";
import test from "node:test";
import { Session } from "../../src/editor/session.js";
import { oneRow, rawWord } from "../oil.js";

class Model {
  saves = [];
  gestures = [];
  set_ = {};
  constructor(state) {
    this.state = state;
  }
  get(name) {
    return this.state[name];
  }
  set(name, value) {
    this.state[name] = this.set_[name] = value;
  }
  save_changes() {
    const { _gesture: gesture, ...saved } = this.set_;
    this.gestures.push(gesture);
    this.saves.push(saved);
    this.set_ = {};
  }
}

function setUp(state = {}) {
  const model = new Model({ _word: rawWord(), axes: { wght: 500 }, shared: true, _pins: [], error: "", ...state });
  const session = new Session(model, () => {});
  /** The kernel changes traits. */
  const kernel = (patch) => {
    Object.assign(model.state, patch);
    for (const name of Object.keys(patch)) session.expire(name);
  };
  assert.equal(session.pull(false), true);
  return { model, session, kernel };
}

const full = (wght, wdth = 100) => ({ wght, wdth });

test("reads a model, missing values as defaults", () => {
  const { session } = setUp();
  assert.deepEqual([session.axes, session.shared, session.pins, session.error], [full(500), true, [], ""]);
  assert.equal(session.pull(false), false);
});

test("axes from the kernel wait for the end of a drag, whose answers come first", () => {
  const { session, kernel } = setUp();
  kernel({ axes: { wght: 600 } });
  session.pull(true);
  assert.deepEqual(session.axes, full(500));
  session.take({ wght: 650 });
  assert.deepEqual(session.axes, full(650));
  session.pull(false); // what the trait said was older than the answer
  assert.deepEqual(session.axes, full(650));
  session.expire("axes"); // but it has the last word
  session.pull(false);
  assert.deepEqual(session.axes, full(600));
});

test("a write shows at once, is saved in one piece, and is not undone by what was on its way", () => {
  const { model, session, kernel } = setUp();
  session.setValues({ wght: 700 });
  session.setValues({ wdth: 80 });
  assert.deepEqual(session.axes, full(700, 80));
  kernel({ axes: { wght: 111 } });
  session.take({ wght: 222 });
  session.pull(false);
  assert.deepEqual([session.axes, model.saves.length], [full(700, 80), 0]);
  session.flush();
  session.flush();
  assert.deepEqual(model.saves, [{ axes: full(700, 80) }]);
  session.pull(false);
  assert.deepEqual(session.axes, full(700, 80));
});

test("axes for each letter and back to shared, in one save each", () => {
  const { model, session } = setUp();
  session.setShared(false);
  session.select(1);
  session.setValues({ wght: 800 });
  session.flush();
  assert.deepEqual(model.saves.at(-1), { shared: false, axes: [full(500), full(800), full(500)] });
  session.setShared(true);
  session.flush();
  assert.deepEqual(model.saves.at(-1), { shared: true, axes: full(800) });
  session.resetAll();
  assert.deepEqual(session.axes, full(400));
});

test("shared and axes a message apart never break the picture", () => {
  const { session, kernel } = setUp();
  kernel({ shared: false });
  session.pull(false);
  assert.deepEqual(session.axes, [1, 2, 3].map(() => full(500)));
  kernel({ axes: [full(1), full(2), full(3)] });
  session.pull(false);
  assert.deepEqual(session.axes[2], full(3));
  kernel({ shared: true });
  session.pull(false);
  assert.deepEqual(session.axes, full(1));
});

test("malformed traits are named and the last good value stays", () => {
  const { session, kernel } = setUp({ _pins: [[0, 0, 0, 0]] });
  kernel({ axes: { wght: "bold" }, _pins: 5, _word: { rows: 1 } });
  session.pull(false);
  assert.deepEqual([session.axes, session.pins, session.word.string], [full(500), [[0, 0, 0, 0]], "oil"]);
  assert.deepEqual([...session.problems.keys()].sort(), ["_pins", "_word", "axes"]);
  assert.throws(() => session.take(7));
  assert.throws(() => session.take({ wght: NaN }));
  kernel({ axes: { wght: 900 }, _pins: [], _word: rawWord() });
  session.pull(false);
  assert.deepEqual([session.axes, session.pins, session.problems.size], [full(900), [], 0]);
});

test("another word drops what was written for the old one", () => {
  const { model, session, kernel } = setUp();
  session.select(2);
  session.setValues({ wght: 700 });
  kernel({ _word: { ...rawWord(), ...oneRow([1]), string: "i" }, axes: { wght: 450 } });
  assert.equal(session.pull(true), true);
  session.flush();
  assert.deepEqual([session.axes, session.selected, model.saves.length], [full(450), 0, 0]);
});

test("a word sent again without a change is no event", () => {
  const { session, kernel } = setUp();
  const { word } = session;
  session.setValues({ wght: 700 });
  kernel({ _word: rawWord() });
  assert.equal(session.pull(false), false);
  assert.deepEqual([session.word, session.axes], [word, full(700)]);
  const other = rawWord();
  other.glyphs[0].points.setFloat32(0, 551, true);
  kernel({ _word: other });
  assert.equal(session.pull(false), true);
});

test("changes by one control in quick succession are one gesture", () => {
  const { model, session } = setUp();
  const save = (...change) => {
    session.setValues(...change);
    session.flush();
  };
  save({ wght: 510 }, "wght");
  save({ wght: 520 }, "wght");
  save({ wdth: 90 }, "wdth");
  session.begin("wdth");
  save({ wdth: 91 }, "wdth");
  session.resetAll();
  session.flush();
  const [a, b, c, d, e] = model.gestures;
  assert.equal(a, b);
  assert.equal(new Set([a, c, d, e]).size, 4);
});

test("locks, the history and the looks are read, and nonsense is named", () => {
  const { session, kernel } = setUp({ locks: ["wght"], _steps: [3, 1], height: 200, theme: "dark" });
  assert.deepEqual([session.locks, session.steps, session.height, session.theme], [["wght"], [3, 1], 200, "dark"]);
  session.toggleLock("wdth");
  session.toggleLock("wght");
  assert.deepEqual(session.locks, ["wdth"]);
  session.flush();
  kernel({ locks: 3, _steps: "x", height: "tall" });
  session.pull(false);
  assert.deepEqual([session.locks, session.steps, session.height], [["wdth"], [0, 0], null]);
  assert.match(session.problems.get("locks"), /not a list/);
});

test("letters that are selected together change together", () => {
  const axes = [{ wght: 500, wdth: 100 }, { wght: 600, wdth: 90 }, { wght: 700, wdth: 100 }];
  const session = new Session(new Model({ _word: rawWord(), axes, shared: false }), () => {});
  session.pull(false);
  session.select(0);
  session.select(1, "to");
  assert.deepEqual([session.range, session.selected], [[0, 1], 0]);
  session.setValues({ wdth: 80 });
  assert.deepEqual(session.axes, [{ wght: 500, wdth: 80 }, { wght: 600, wdth: 80 }, { wght: 700, wdth: 100 }]);
  session.select(1, "within");
  assert.deepEqual([session.range, session.selected], [[0, 1], 1]);
  assert.deepEqual(session.together[0], { wght: 600, wdth: 80 });
  session.select(2, "within");
  assert.deepEqual(session.range, [2, 2]);
});
