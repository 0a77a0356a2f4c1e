/**
 * What the view shows of a model, and how the two stay in step. The model's traits are the truth;
 * the view runs ahead of it while a drag is being answered and while a write of its own waits.
 */
import { alike, conform, decodeWord, isArray } from "../word/decode.js";
import { checkConstraint } from "./constraints.js";

/**
 * @typedef {import("../word/forward.js").Handle} Handle
 * @typedef {Record<string, number>} Values
 */

const number = (/** @type {any} */ value) => Number(value) || 0;

/** @param {any} value */
function list(value) {
  if (!isArray(value ?? [])) throw new Error("this is not a list");
  return value ?? [];
}

/** How each trait that stands by itself is read: the field of a session, and its value. @type {Record<string, [string, (value: any) => any]>} */
const FIELDS = {
  _pins: ["pins", list],
  locks: ["locks", (value) => list(value).map(String)],
  constraints: ["constraints", (value) => list(value).map(checkConstraint)],
  avoid_overlaps: ["apart", (value) => value ?? null],
  teaching: ["teaching", Boolean],
  _obstacles: ["backdrop", (value) => value ?? ""],
  _steps: ["steps", (value) => [0, 1].map((i) => number(value?.[i]))],
  height: ["height", (value) => number(value) || null],
  theme: ["theme", (value) => String(value || "auto")],
  throttle: ["throttle", number],
  error: ["error", (value) => String(value || "")],
};
export const TRAITS = ["_word", "axes", "shared", ...Object.keys(FIELDS)];

/** Milliseconds between two changes by the same control that still count as one gesture. */
const PAUSE = 1000;

export class Session {
  #changed; #stale; #model; #waiting;

  /** @param {any} model anywidget's @param {() => void} changed asks for a frame */
  constructor(model, changed) {
    this.#model = model;
    this.#changed = changed;
    /** @type {import("../word/decode.js").Word | null} */
    this.word = null;
    /** @type {Values | Values[]} */
    this.axes = {};
    this.shared = true;
    /** @type {Handle[]} */
    this.pins = [];
    /** Tags of axes that drags leave as they are. @type {string[]} */
    this.locks = [];
    /** @type {import("../solver/terms.js").Constraint[]} */
    this.constraints = [];
    this.error = "";
    /** How many steps can be undone and redone. */
    this.steps = [0, 0];
    /** Pixels, or null for the usual height. @type {number | null} */
    this.height = null;
    this.theme = "auto";
    /** The least number of milliseconds between two moves that are sent. */
    this.throttle = 0;
    /** Whether drags avoid overlaps; null where nobody can see to it. @type {boolean | null} */
    this.apart = null;
    /** Path data of what is drawn behind the word. */
    this.backdrop = "";
    /** Whether the numbers behind the letters are shown. */
    this.teaching = false;
    /** The letter that was chosen last, and the range of letters that change together with it. */
    this.selected = 0;
    /** @type {[first: number, last: number]} */
    this.range = [0, 0];
    /** Names the present gesture, so that undoing it is one step; and what made its last change, and when. */
    this.gesture = { name: "", source: "", time: -Infinity };
    /** Counts changes of the picture. */
    this.version = 0;
    /** Traits to read again. @type {Set<string>} */
    this.#stale = new Set(TRAITS);
    /** Own changes that the model does not have yet. @type {Record<string, any>} */
    this.#waiting = {};
    /** What is wrong with a trait; the last good value stays. @type {Map<string, string>} */
    this.problems = new Map();
  }

  /** Axes of this word, one set of values for all letters or one for each. @param {any} axes @returns {Values | Values[]} */
  conform(axes, shared = this.shared) {
    return conform(/** @type {any} */ (this.word), axes, shared, this.selected);
  }

  /** @param {string} trait */
  expire(trait) {
    this.#stale.add(trait);
    this.#changed();
  }

  /**
   * Reads what changed. Axes are left alone while the view is ahead of the model: in a drag, whose
   * answers bring them, and for a while after a change of its own.
   * @param {boolean} ahead
   * @returns {boolean} whether there is another word
   */
  pull(ahead) {
    let fresh = false;
    this.#read("_word", () => {
      const word = decodeWord(this.#model.get("_word"));
      // Python may send a word again without a change: what is under way on it goes on.
      if (alike(word, this.word)) return;
      fresh = true;
      this.word = word;
      this.select(Math.min(this.selected, Math.max(0, word.rows[0].order.length - 1)));
      for (const trait of /** @type {const} */ (["axes", "shared", "_pins", "constraints"])) this.#stale.add(trait);
      // What is said of the old word means nothing on the new one.
      this.#waiting = {};
      this.axes = this.conform({});
    });
    if (this.word !== null && (fresh || (!ahead && !("axes" in this.#waiting)))) {
      if (this.#stale.delete("shared")) this.#stale.add("axes");
      this.#read("axes", () => {
        const shared = this.#model.get("shared") !== false;
        this.axes = this.conform(this.#model.get("axes"), shared);
        this.shared = shared;
      });
    }
    for (const [trait, [field, read]] of Object.entries(FIELDS)) {
      if (!(trait in this.#waiting)) this.#read(trait, () => this.#show(field, read(this.#model.get(trait))));
    }
    return fresh;
  }

  /** @param {string} field @param {any} value */
  #show(field, value) {
    Object.assign(this, { [field]: value });
  }

  /** @param {string} trait @param {() => void} take */
  #read(trait, take) {
    if (!this.#stale.delete(trait)) return;
    this.version++;
    try {
      take();
      this.problems.delete(trait);
    } catch (error) {
      this.problems.set(trait, `${trait}: ${/** @type {Error} */ (error).message}`);
    }
  }

  /**
   * Takes the axes of a drag's answer, which are newer than what the trait has said so far.
   * @param {any} axes
   * @returns {boolean} false when the view has changed the axes since, and so does not want these
   */
  take(axes) {
    if ("axes" in this.#waiting || this.word === null) return false;
    if (axes === null || typeof axes !== "object") throw new Error("the answer has no axes");
    this.axes = this.conform(axes);
    this.#stale.delete("axes");
    this.version++;
    return true;
  }

  /**
   * Saves the end of a drag. The kernel knows its axes, but a host that runs cells again when a view saves, as marimo
   * does, hears of them only in this way.
   * @param {string} gesture
   */
  finish(gesture) {
    this.#model.set("axes", this.axes);
    this.#model.set("_gesture", gesture);
    this.#model.save_changes();
  }

  /** Shows axes that a drag predicts; the kernel is told of them by the drag itself. @param {Values | Values[]} axes */
  predict(axes) {
    this.axes = axes;
    this.version++;
    this.#changed();
  }

  /**
   * Shows a change at once and keeps it for `flush`.
   * @param {{axes?: any, shared?: boolean, _pins?: Handle[], locks?: string[], constraints?: any[], avoid_overlaps?: boolean, teaching?: boolean}} patch
   * @param {string} [source] what makes the change; changes of one source in quick succession are one step of undo
   */
  write(patch, source = "") {
    this.resume(source);
    Object.assign(this.#waiting, patch, { _gesture: this.gesture.name });
    for (const [trait, value] of Object.entries(patch)) this.#show(FIELDS[trait]?.[0] ?? trait, value);
    this.version++;
    this.#changed();
  }

  /** The changes that follow belong to the last gesture if that has the same source and is not long ago. @param {string} source */
  resume(source) {
    const now = performance.now(), { gesture } = this;
    if (source === "" || source !== gesture.source || now - gesture.time > PAUSE) this.begin(source);
    this.gesture.time = now;
  }

  /** The changes that follow are another step of undo. @param {string} [source] */
  begin(source = "") {
    this.gesture = { name: Math.random().toString(36).slice(2), source, time: performance.now() };
  }

  /** Gives the model what waits, all in one save. @returns {boolean} whether there was anything */
  flush() {
    const patch = Object.entries(this.#waiting);
    if (patch.length === 0) return false;
    this.#waiting = {};
    for (const [trait, value] of patch) this.#model.set(trait, value);
    this.#model.save_changes();
    return true;
  }

  /** What drags keep as it is. */
  get wishes() {
    return { locks: this.locks, constraints: this.constraints, range: this.range };
  }

  /** The axes where all letters of the range take those of the selected one. */
  get together() {
    const { axes, values } = this;
    return isArray(axes) ? axes.map((own, i) => (this.chosen(i) ? values : own)) : axes;
  }

  /** Is a letter in the range that changes together? @param {number} letter */
  chosen(letter) {
    return letter >= this.range[0] && letter <= this.range[1];
  }

  /** The values that the sliders act on. @returns {Values} */
  get values() {
    return isArray(this.axes) ? this.axes[this.selected] ?? {} : this.axes;
  }

  /** @param {Values} changes axis values of the letters of the range, or of all when they share them @param {string} [source] */
  setValues(changes, source) {
    const { axes } = this;
    this.write({
      axes: isArray(axes)
        ? axes.map((values, i) => (this.chosen(i) ? { ...values, ...changes } : values))
        : { ...axes, ...changes },
    }, source);
  }

  resetAll() {
    if (this.word !== null) this.write({ axes: this.conform({}) });
  }

  /** @param {boolean} shared */
  setShared(shared) {
    if (this.word === null || shared === this.shared) return;
    this.write({ shared, axes: this.conform(this.axes, shared) });
  }

  /** Locks an axis, or unlocks it. @param {string} tag */
  toggleLock(tag) {
    const others = this.locks.filter((lock) => lock !== tag);
    this.write({ locks: others.length < this.locks.length ? others : [...others, tag] });
  }

  /**
   * Selects a letter.
   * @param {number} letter
   * @param {"alone" | "within" | "to"} [how] alone; within the range if that has it; or the range up to this letter
   */
  select(letter, how = "alone") {
    const { selected } = this;
    if (how === "to") this.range = [Math.min(selected, letter), Math.max(selected, letter)];
    else {
      if (how === "alone" || !this.chosen(letter)) this.range = [letter, letter];
      this.selected = letter;
    }
    this.version++;
    this.#changed();
  }
}
