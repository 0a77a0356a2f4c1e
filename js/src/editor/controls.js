/** The panel under the word: the letters, and a row for each axis. */
import { attr, html, icon, KEEP_KEYS } from "../view/dom.js";
import { alike } from "../word/decode.js";

/**
 * @typedef {import("../word/decode.js").Axis} Axis
 * @typedef {object} Actions
 * @property {(changes: Record<string, number>, source?: string) => void} set
 * @property {(source: string) => void} begin starts a step of undo
 * @property {(tag: string) => void} lock
 * @property {(letter: number) => void} select
 */

/** A round number near a hundredth of the axis: what an arrow key moves. @param {Axis} axis */
function keyStep({ minimum, maximum }) {
  const rough = (maximum - minimum) / 100 || 1, power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].map((m) => m * power).reduce((a, b) => (Math.abs(b - rough) < Math.abs(a - rough) ? b : a));
}

/** A user value in as many digits as a thousandth of the axis needs. @param {Axis} axis @param {number} value */
export function format({ minimum, maximum }, value) {
  const digits = 3 - Math.floor(Math.log10(maximum - minimum || 1));
  return String(Number(value.toFixed(Math.min(6, Math.max(0, digits)))));
}

const LOCK = "M4.5 7.2h7v5.6h-7zM6 7.2V5.4a2 2 0 0 1 4 0v1.8", OPEN = "M4.5 7.2h7v5.6h-7zM6 7.2V4.4a2 2 0 0 1 4 0";
const RESET = "M3.2 6.2A5.2 5.2 0 1 1 2.9 9.6M3 2.6v3.8h3.8";

/** One axis: name, slider, number, lock, reset. */
class Row {
  /** @param {Axis} axis @param {Actions} actions @param {string} id */
  constructor(axis, actions, id) {
    const { tag, name, minimum, maximum } = axis;
    this.axis = axis;
    this.value = axis.default;
    this.typing = false;
    const limits = { min: minimum, max: maximum, step: "any", "data-tag": tag, [KEEP_KEYS]: "true" };
    const set = (/** @type {number} */ value) => {
      if (!Number.isFinite(value)) return;
      this.show(Math.min(maximum, Math.max(minimum, value)));
      actions.set({ [tag]: this.value }, tag);
    };
    // Browsers disagree on what an arrow key does to a slider without steps.
    const onkeydown = (/** @type {KeyboardEvent} */ event) => {
      const amount = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 }[event.key];
      const sideways = event.key === "ArrowLeft" || event.key === "ArrowRight";
      if (!amount || (event.target === this.number && sideways)) return;
      event.preventDefault();
      this.typing = false;
      set(Number((this.value + amount * (event.shiftKey ? 10 : 1) * keyStep(axis)).toPrecision(12)));
    };
    this.range = html("input", {
      ...limits, type: "range", id, onkeydown,
      oninput: () => set(this.range.valueAsNumber),
      onpointerdown: () => {
        this.pressed = true;
        actions.begin(tag);
        // The release may happen anywhere.
        for (const type of ["pointerup", "pointercancel"]) addEventListener(type, () => (this.pressed = false), { once: true });
      },
    });
    this.pressed = false;
    this.number = html("input", {
      ...limits, type: "number", "aria-label": `${name}, value`, inputmode: "decimal", onkeydown,
      oninput: () => {
        this.typing = true;
        const value = this.number.valueAsNumber;
        if (value >= minimum && value <= maximum) set(value);
      },
      onchange: () => {
        this.typing = false;
        set(this.number.valueAsNumber);
        this.show(this.value);
      },
      onblur: () => {
        this.typing = false;
        this.show(this.value);
      },
    });
    this.lockIcon = icon(OPEN);
    this.lock = html("button", {
      type: "button", class: "vfw-lock", "data-lock": tag, onclick: () => actions.lock(tag), "aria-label": `Lock ${name}`,
      title: `Lock ${name}: drags leave this axis as it is`, "aria-pressed": "false",
    }, this.lockIcon);
    this.reset = html("button", {
      type: "button", class: "vfw-reset", "data-reset": tag,
      onclick: () => {
        actions.begin(tag);
        set(axis.default);
      },
      "aria-label": `Reset ${name} to ${format(axis, axis.default)}`, title: `Reset to the default, ${format(axis, axis.default)}`,
    }, icon(RESET));
    this.element = html("div", { class: "vfw-axis" },
      html("label", { for: id, title: `${name} (${tag}): ${format(axis, minimum)} to ${format(axis, maximum)}` },
        html("span", { class: "vfw-name" }, name), " ", html("code", {}, tag)),
      this.range, this.number, this.lock, this.reset);
    this.range.style.setProperty("--vfw-default", String(this.part(axis.default)));
    this.show(axis.default);
  }

  /** How far along the slider a value is. @param {number} value */
  part(value) {
    const { minimum, maximum } = this.axis;
    return maximum > minimum ? Math.min(1, Math.max(0, (value - minimum) / (maximum - minimum))) : 0;
  }

  /** @param {boolean} locked */
  setLocked(locked) {
    attr(this.lock, "aria-pressed", locked);
    this.lockIcon.firstElementChild?.setAttribute("d", locked ? LOCK : OPEN);
  }

  /** @param {number} value */
  show(value) {
    this.value = value;
    const here = this.part(value), home = this.part(this.axis.default);
    if (this.range.valueAsNumber !== value) this.range.value = String(value);
    this.range.style.setProperty("--vfw-low", String(Math.min(here, home)));
    this.range.style.setProperty("--vfw-high", String(Math.max(here, home)));
    attr(this.range, "aria-valuetext", format(this.axis, value));
    if (!this.typing) this.number.value = format(this.axis, value);
    this.reset.disabled = value === this.axis.default;
  }
}

export class Controls {
  /** @param {Actions} actions @param {string} id distinct among the views of a page */
  constructor(actions, id) {
    this.actions = actions;
    this.id = id;
    /** @type {Row[]} */
    this.rows = [];
    /** What each letter is called. @type {string[]} */
    this.names = [];
    this.axes = html("div", { class: "vfw-axes" });
    this.summary = html("summary");
    this.letters = html("div", { class: "vfw-letters-bar", role: "group", "aria-label": "Letter that the sliders act on" });
    this.element = html("div", { class: "vfw-controls" }, this.letters, this.axes);
  }

  /** @param {import("../word/decode.js").Word} word */
  setWord(word) {
    // Rows stay where they can, and with them the focus and what is unfolded.
    if (!alike(word.axes, this.rows.map((row) => row.axis))) this.setAxes(word.axes);
    const characters = [...word.string];
    const { order } = word.rows[0];
    this.names = order.map((g, i) => (characters.length === order.length ? characters[i] : word.glyphs[g].name));
    this.letters.replaceChildren(...this.names.map((name, i) => html("button", {
      type: "button", class: "vfw-chip", title: word.glyphs[order[i]].name,
      "aria-label": `Letter ${i + 1}, ${name}`, onclick: () => this.actions.select(i),
    }, name)));
  }

  /** @private @param {Axis[]} axes */
  setAxes(axes) {
    this.rows = axes.map((axis, i) => new Row(axis, this.actions, `${this.id}-${i}`));
    const [hidden, open] = [true, false].map((h) => this.rows.filter((r) => r.axis.hidden === h).map((r) => r.element));
    this.axes.replaceChildren(html("div", { class: "vfw-rows" }, ...open));
    if (hidden.length > 0) {
      this.axes.append(html("details", { class: "vfw-hidden" }, this.summary, html("div", { class: "vfw-rows" }, ...hidden)));
    }
  }

  /** Is a slider held down? */
  get pressed() {
    return this.rows.some((row) => row.pressed);
  }

  /** @param {{values: Record<string, number>, locks: string[], shared: boolean, selected: number}} state */
  show({ values, locks, shared, selected }) {
    for (const row of this.rows) {
      row.show(values[row.axis.tag] ?? row.axis.default);
      row.setLocked(locks.includes(row.axis.tag));
    }
    const hidden = this.rows.filter((row) => row.axis.hidden), moved = hidden.filter((row) => row.value !== row.axis.default);
    this.summary.textContent = `Hidden axes (${hidden.length}${moved.length > 0 ? `, ${moved.length} moved` : ""})`;
    this.letters.hidden = shared;
    [...this.letters.children].forEach((chip, i) => attr(chip, "aria-pressed", i === selected));
  }
}
