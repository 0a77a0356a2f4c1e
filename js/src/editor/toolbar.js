/** The buttons of an editor: history, the whole word, and the window. */
import { attr, html, icon, KEEP_KEYS } from "../view/dom.js";

/**
 * @typedef {object} Actions
 * @property {() => void} undo
 * @property {() => void} redo
 * @property {() => void} restart
 * @property {() => void} resetAll
 * @property {() => void} unpinAll
 * @property {(shared: boolean) => void} share
 * @property {(apart: boolean) => void} keepApart
 * @property {(instance: number) => void} instance
 * @property {(what: string) => void} save
 * @property {(factor: number) => void} zoom
 * @property {() => void} fit
 */

const ICONS = {
  undo: "M6 3 2.8 6.2 6 9.4M3 6.2h6.2a3.6 3.6 0 0 1 0 7.2H6", redo: "m10 3 3.2 3.2L10 9.4M13 6.2H6.8a3.6 3.6 0 0 0 0 7.2H10",
  closer: "M8 3.5v9M3.5 8h9", farther: "M3.5 8h9", fit: "M3 6V3h3M10 3h3v3M13 10v3h-3M6 13H3v-3",
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

export class Toolbar {
  /** @param {Actions} actions */
  constructor(actions) {
    const button = (/** @type {string} */ name, /** @type {string} */ text, /** @type {() => void} */ onclick) =>
      html("button", { type: "button", class: `vfw-button ${name}`, onclick }, text);
    const picture = (/** @type {keyof typeof ICONS} */ name, /** @type {string} */ label, /** @type {() => void} */ onclick) =>
      html("button", { type: "button", class: `vfw-tool vfw-${name}`, "aria-label": label, title: label, onclick }, icon(ICONS[name]));
    this.undo = picture("undo", "Undo (Ctrl+Z)", actions.undo);
    this.redo = picture("redo", "Redo (Ctrl+Shift+Z)", actions.redo);
    this.restart = button("vfw-restart", "Back to start", actions.restart);
    this.unpin = button("vfw-unpin-all", "Unpin all", actions.unpinAll);
    this.reset = button("vfw-reset-all", "Reset to default", actions.resetAll);
    this.instances = menu("vfw-instances", "Named instances", (value) => actions.instance(Number(value)));
    this.saving = menu("vfw-save", "Copy or save", actions.save);
    this.saving.append(...["Copy CSS", "Copy Python", "Save SVG", "Save PNG"].map((name) => html("option", {}, name)));
    const box = (/** @type {string} */ name, /** @type {() => void} */ onchange) => html("input", { type: "checkbox", class: name, onchange });
    const label = (/** @type {Node} */ input, /** @type {string} */ text) => html("label", { class: "vfw-switch" }, input, html("span", {}, text));
    this.perLetter = box("vfw-per-letter", () => actions.share(!this.perLetter.checked));
    this.apart = box("vfw-apart", () => actions.keepApart(this.apart.checked));
    this.apartLabel = label(this.apart, "Avoid overlaps");
    this.element = html("div", { class: "vfw-actions" },
      html("span", { class: "vfw-group" }, this.undo, this.redo), this.restart, this.reset, this.unpin, this.instances, this.saving,
      label(this.perLetter, "Separate axes for each letter"), this.apartLabel);
    this.window = html("div", { class: "vfw-window", role: "group", "aria-label": "Zoom" },
      picture("farther", "Zoom out (−)", () => actions.zoom(-1)), picture("closer", "Zoom in (+)", () => actions.zoom(1)),
      picture("fit", "Show the whole word (0)", actions.fit));
  }

  /** @param {import("../word/decode.js").Word} word */
  setWord({ instances }) {
    this.instances.hidden = instances.length === 0;
    this.instances.length = 1;
    this.instances.append(...instances.map(({ name }, i) => html("option", { value: i }, name)));
  }

  /** @param {{shared: boolean, apart: boolean | null, pins: number, moved: boolean, steps: number[]}} state */
  show({ shared, apart, pins, moved, steps }) {
    this.perLetter.checked = !shared;
    this.apart.checked = !!apart;
    this.apartLabel.hidden = apart === null;
    this.unpin.disabled = pins === 0;
    this.unpin.textContent = pins > 0 ? `Unpin all (${pins})` : "Unpin all";
    this.reset.disabled = !moved;
    // A button that is disabled loses the focus, and the keys for undo and redo with it.
    for (const [tool, count] of [[this.undo, steps[0]], [this.restart, steps[0]], [this.redo, steps[1]]]) {
      attr(/** @type {HTMLElement} */ (tool), "aria-disabled", count === 0);
    }
  }
}
