/** The buttons of an editor: history, the whole word, and the window. */
import { assign, attr, html, icon, KEEP_KEYS } from "../view/dom.js";

/**
 * @typedef {object} Actions
 * @property {() => void} undo
 * @property {() => void} redo
 * @property {() => void} restart
 * @property {() => void} resetAll
 * @property {() => void} unpinAll
 * @property {(shared: boolean) => void} share
 * @property {(apart: boolean) => void} keepApart
 * @property {(teaching: boolean) => void} teach
 * @property {() => void} reach shows what the held point can reach, or no more
 * @property {(instance: number) => void} instance
 * @property {(what: string) => void} save
 * @property {(factor: number) => void} zoom
 * @property {() => void} fit
 */

const ICONS = {
  undo: "M6 3 2.8 6.2 6 9.4M3 6.2h6.2a3.6 3.6 0 0 1 0 7.2H6", redo: "m10 3 3.2 3.2L10 9.4M13 6.2H6.8a3.6 3.6 0 0 0 0 7.2H10",
  closer: "M8 3.5v9M3.5 8h9", farther: "M3.5 8h9", fit: "M3 6V3h3M10 3h3v3M13 10v3h-3M6 13H3v-3",
  reach: "M8 1.8v2.4M8 11.8v2.4M1.8 8h2.4M11.8 8h2.4M4.5 8a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0-7 0",
};

/**
 * A menu of actions, whose first line is its name.
 * @param {string} className @param {string} label @param {(value: string) => void} choose
 */
export function menu(className, label, choose) {
  const element = html("select", {
    class: className, "aria-label": label, [KEEP_KEYS]: "true",
    onchange: () => {
      const { value } = element;
      element.selectedIndex = 0;
      if (value !== "") choose(value);
    },
  }, html("option", { value: "" }, label));
  return element;
}

/** @param {Actions} actions */
export function createToolbar(actions) {
  const button = (/** @type {string} */ name, /** @type {string} */ text, /** @type {() => void} */ onclick) =>
    html("button", { type: "button", class: name, onclick }, text);
  const picture = (/** @type {keyof typeof ICONS} */ name, /** @type {string} */ label, /** @type {() => void} */ onclick) =>
    html("button", { type: "button", class: `vfw-tool vfw-${name}`, "aria-label": label, title: label, onclick }, icon(ICONS[name]));
  const undo = picture("undo", "Undo (Ctrl+Z)", actions.undo);
  const redo = picture("redo", "Redo (Ctrl+Shift+Z)", actions.redo);
  const restart = button("vfw-restart", "Back to start", actions.restart);
  const unpin = button("vfw-unpin-all", "Unpin all", actions.unpinAll);
  const reset = button("vfw-reset-all", "Reset to default", actions.resetAll);
  const named = menu("vfw-instances", "Named instances", (value) => actions.instance(Number(value)));
  const saving = menu("vfw-save", "Copy or save", actions.save);
  saving.append(...["Copy CSS", "Copy Python", "Save SVG", "Save PNG"].map((name) => html("option", {}, name)));
  const box = (/** @type {string} */ name, /** @type {() => void} */ onchange) => html("input", { type: "checkbox", class: name, onchange });
  const label = (/** @type {Node} */ input, /** @type {string} */ text) => html("label", { class: "vfw-switch" }, input, html("span", {}, text));
  const perLetter = box("vfw-per-letter", () => actions.share(!perLetter.checked));
  const avoid = box("vfw-apart", () => actions.keepApart(avoid.checked));
  const avoidLabel = label(avoid, "Avoid overlaps");
  const teach = box("vfw-teaching", () => actions.teach(teach.checked));
  const reach = picture("reach", "Show what the held point can reach", actions.reach);
  const element = html("div", { class: "vfw-actions" },
    html("span", { class: "vfw-group" }, undo, redo), restart, reset, unpin, named, saving,
    label(perLetter, "Separate axes for each letter"), avoidLabel, label(teach, "Show the numbers"));
  const window = html("div", { class: "vfw-window", role: "group", "aria-label": "View" }, reach,
    picture("farther", "Zoom out (−)", () => actions.zoom(-1)), picture("closer", "Zoom in (+)", () => actions.zoom(1)),
    picture("fit", "Show the whole word (0)", actions.fit));

  /** @param {import("../word/decode.js").Word} word */
  function setWord({ instances }) {
    named.hidden = instances.length === 0;
    named.length = 1;
    named.append(...instances.map(({ name }, i) => html("option", { value: i }, name)));
  }

  /** @param {import("./session.js").Session} session @param {boolean} moved whether an axis is not at its default @param {boolean} reaching */
  function show({ shared, apart, teaching, pins: { length: pins }, steps }, moved, reaching) {
    perLetter.checked = !shared;
    avoid.checked = !!apart;
    assign(avoidLabel, { hidden: apart === null });
    teach.checked = teaching;
    attr(reach, "aria-pressed", reaching);
    unpin.disabled = pins === 0;
    assign(unpin, { textContent: pins > 0 ? `Unpin all (${pins})` : "Unpin all" });
    reset.disabled = !moved;
    // A button that is disabled loses the focus, and the keys for undo and redo with it.
    for (const [tool, count] of [[undo, steps[0]], [restart, steps[0]], [redo, steps[1]]]) {
      attr(/** @type {HTMLElement} */ (tool), "aria-disabled", count === 0);
    }
  }

  return { element, window, unpin, setWord, show };
}
