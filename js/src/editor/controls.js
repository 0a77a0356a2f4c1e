/** The panel under the word: the letters, and a row for each axis. */
import { assign, attr, html, icon, KEEP_KEYS } from "../view/dom.js";
import { alike } from "../word/decode.js";

/**
 * @typedef {import("../word/decode.js").Axis} Axis
 * @typedef {object} Actions
 * @property {(changes: Record<string, number>, source?: string) => void} set
 * @property {(source: string) => void} begin starts a step of undo
 * @property {(tag: string) => void} lock
 * @property {(letter: number, how: "alone" | "to") => void} select
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

/** One axis: name, slider, number, lock, reset. @param {Axis} axis @param {Actions} actions @param {string} id */
function createRow(axis, actions, id) {
  const { tag, name, minimum, maximum } = axis;
  let value = axis.default, typing = false, pressed = false;
  const limits = { min: minimum, max: maximum, step: "any", "data-tag": tag, [KEEP_KEYS]: "true" };
  const set = (/** @type {number} */ wanted) => {
    if (!Number.isFinite(wanted)) return;
    show(Math.min(maximum, Math.max(minimum, wanted)));
    actions.set({ [tag]: value }, tag);
  };
  // Browsers disagree on what an arrow key does to a slider without steps.
  const onkeydown = (/** @type {KeyboardEvent} */ event) => {
    const amount = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 }[event.key];
    const sideways = event.key === "ArrowLeft" || event.key === "ArrowRight";
    if (!amount || (event.target === number && sideways)) return;
    event.preventDefault();
    typing = false;
    set(Number((value + amount * (event.shiftKey ? 10 : 1) * keyStep(axis)).toPrecision(12)));
  };
  const range = html("input", {
    ...limits, type: "range", id, onkeydown,
    oninput: () => set(range.valueAsNumber),
    onpointerdown: () => {
      pressed = true;
      actions.begin(tag);
      // The release may happen anywhere.
      for (const type of ["pointerup", "pointercancel"]) addEventListener(type, () => (pressed = false), { once: true });
    },
  });
  const number = html("input", {
    ...limits, type: "number", "aria-label": `${name}, value`, inputmode: "decimal", onkeydown,
    oninput: () => {
      typing = true;
      const typed = number.valueAsNumber;
      if (typed >= minimum && typed <= maximum) set(typed);
    },
    onchange: () => {
      typing = false;
      set(number.valueAsNumber);
      show(value);
    },
    onblur: () => {
      typing = false;
      show(value);
    },
  });
  const lockIcon = icon(OPEN);
  const lock = html("button", {
    type: "button", class: "vfw-lock", "data-lock": tag, onclick: () => actions.lock(tag), "aria-label": `Lock ${name}`,
    title: `Lock ${name}: drags leave this axis as it is`, "aria-pressed": "false",
  }, lockIcon);
  const reset = html("button", {
    type: "button", class: "vfw-reset", "data-reset": tag,
    onclick: () => {
      actions.begin(tag);
      set(axis.default);
    },
    "aria-label": `Reset ${name} to ${format(axis, axis.default)}`, title: `Reset to the default, ${format(axis, axis.default)}`,
  }, icon(RESET));
  const element = html("div", { class: "vfw-axis" },
    html("label", { for: id, title: `${name} (${tag}): ${format(axis, minimum)} to ${format(axis, maximum)}` },
      html("span", { class: "vfw-name" }, name), " ", html("code", {}, tag)),
    range, number, lock, reset);
  range.style.setProperty("--vfw-default", String(part(axis.default)));
  show(axis.default);

  /** How far along the slider a value is. @param {number} at */
  function part(at) {
    return maximum > minimum ? Math.min(1, Math.max(0, (at - minimum) / (maximum - minimum))) : 0;
  }

  /** @param {boolean} locked */
  function setLocked(locked) {
    attr(lock, "aria-pressed", locked);
    attr(/** @type {Element} */ (lockIcon.firstElementChild), "d", locked ? LOCK : OPEN);
  }

  /** @param {number} shown */
  function show(shown) {
    value = shown;
    const here = part(value), home = part(axis.default);
    if (range.valueAsNumber !== value) range.value = String(value);
    range.style.setProperty("--vfw-low", String(Math.min(here, home)));
    range.style.setProperty("--vfw-high", String(Math.max(here, home)));
    attr(range, "aria-valuetext", format(axis, value));
    if (!typing) number.value = format(axis, value);
    reset.disabled = value === axis.default;
  }

  return { axis, element, show, setLocked, get value() { return value; }, get pressed() { return pressed; } };
}

/** @param {Actions} actions @param {string} id distinct among the views of a page */
export function createControls(actions, id) {
  /** @type {ReturnType<typeof createRow>[]} */
  let rows = [];
  /** The letter on which a slide over the letters began; -1 for none. */
  let pressed = -1;
  /** What each letter is called. @type {string[]} */
  let names = [];
  const panel = html("div", { class: "vfw-axes" });
  const summary = html("summary");
  const letters = html("div", { class: "vfw-letters-bar", role: "group", "aria-label": "Letters that sliders act on", title: "Hold Shift or slide to select several letters that share their axes." });
  const element = html("div", { class: "vfw-controls" }, letters, panel);

  /** @param {import("../word/decode.js").Word} word */
  function setWord(word) {
    // Rows stay where they can, and with them the focus and what is unfolded.
    if (!alike(word.axes, rows.map((row) => row.axis))) setAxes(word.axes);
    const { order } = word.rows[0];
    // A mark by itself stands on a dotted circle.
    names = word.rows[0].names.map((name) => name.replace(/^\p{M}/u, "\u25cc$&"));
    letters.replaceChildren(...names.map((name, i) => html("button", {
      type: "button", class: "vfw-chip", title: word.glyphs[order[i]].name,
      "aria-label": `Letter ${i + 1}, ${name}`,
      // Shift selects a range, and so does a slide over the letters.
      onclick: (/** @type {MouseEvent} */ event) => actions.select(i, event.shiftKey ? "to" : "alone"),
      onpointerdown: (/** @type {PointerEvent} */ event) => {
        /** @type {Element} */ (event.target).releasePointerCapture(event.pointerId);
        pressed = i;
      },
      onpointerover: (/** @type {PointerEvent} */ event) => {
        if (!event.buttons) pressed = -1;
        if (pressed < 0) return;
        actions.select(pressed, "alone");
        actions.select(i, "to");
      },
    }, name)));
  }

  /** @param {Axis[]} axes */
  function setAxes(axes) {
    rows = axes.map((axis, i) => createRow(axis, actions, `${id}-${i}`));
    const [hidden, open] = [true, false].map((h) => rows.filter((r) => r.axis.hidden === h).map((r) => r.element));
    panel.replaceChildren(html("div", { class: "vfw-rows" }, ...open));
    if (hidden.length > 0) {
      panel.append(html("details", { class: "vfw-hidden" }, summary, html("div", { class: "vfw-rows" }, ...hidden)));
    }
  }

  /** @param {import("./session.js").Session} session */
  function show(session) {
    const { values, locks, shared } = session;
    for (const row of rows) {
      row.show(values[row.axis.tag] ?? row.axis.default);
      row.setLocked(locks.includes(row.axis.tag));
    }
    const hidden = rows.filter((row) => row.axis.hidden), moved = hidden.filter((row) => row.value !== row.axis.default);
    assign(summary, { textContent: `Hidden axes (${hidden.length}${moved.length > 0 ? `, ${moved.length} moved` : ""})` });
    assign(letters, { hidden: shared });
    [...letters.children].forEach((chip, i) => attr(chip, "aria-pressed", session.chosen(i)));
  }

  return {
    element, setWord, show,
    get names() { return names; },
    /** Is a slider held down? */
    get pressed() { return rows.some((row) => row.pressed); },
  };
}
