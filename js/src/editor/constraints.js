/** Constraints between points: the menu that adds them, and a chip for each that names it and removes it. */
import { assign, html, KEEP_KEYS } from "../view/dom.js";
import { menu } from "./toolbar.js";
import { isArray } from "../word/decode.js";

/**
 * @typedef {import("../solver/terms.js").Constraint} Constraint
 * @typedef {Constraint["kind"]} Kind
 * @typedef {object} Actions
 * @property {(kind: Kind) => void} add from the pins
 * @property {(index: number) => void} remove
 * @property {(index: number, value: number) => void} change the distance or the width
 */

/** What each kind is called, and how many pins it takes. @type {Record<Kind, {label: string, least: number, most: number}>} */
export const KINDS = {
  SharedX: { label: "Align vertically", least: 2, most: Infinity },
  SharedY: { label: "Align horizontally", least: 2, most: Infinity },
  Collinear: { label: "Keep on a line", least: 3, most: Infinity },
  Distance: { label: "Keep the distance", least: 2, most: 2 },
  Width: { label: "Keep the width of the word", least: 0, most: Infinity },
};

/** What the constraint of the width is called where there are several lines. */
const LINES = "Make all lines equally wide";

/** @param {any} raw @returns {Constraint} */
export function checkConstraint(raw) {
  const kind = /** @type {Kind} */ (raw?.kind), handles = raw?.handles ?? [];
  if (!Object.hasOwn(KINDS, kind) || !isArray(handles)) throw new Error("a constraint is malformed");
  if (kind !== "Width" && (handles.length < KINDS[kind].least || handles.length > KINDS[kind].most)) {
    throw new Error(`the constraint ${KINDS[kind].label.toLowerCase()} has ${handles.length} points`);
  }
  if (kind !== "Distance" && kind !== "Width") return { kind, handles };
  if (typeof raw.value !== "number" || !(raw.value >= 0)) throw new Error("the value of a constraint is not a number");
  return { kind, handles, value: raw.value };
}

/** @param {Actions} actions */
export function createConstraintBar(actions) {
  const options = Object.entries(KINDS).map(([kind, { label }]) => html("option", { value: kind }, label));
  const adding = menu("vfw-add-constraint", "Add a constraint", (kind) => actions.add(/** @type {Kind} */ (kind)));
  adding.title = "Pin the points first; a constraint takes the place of their pins.";
  adding.append(...options);
  const element = html("div", { class: "vfw-constraints", role: "group", "aria-label": "Constraints" });
  let shown = "";

  /**
   * @param {Constraint[]} constraints @param {number} pins @param {number[]} lines the line of each letter
   * @param {(letter: number) => string} nameOf a letter's name
   */
  function show(constraints, pins, lines, nameOf) {
    const labelOf = (/** @type {Kind} */ kind) => (kind === "Width" && lines.some((line) => line !== lines[0]) ? LINES : KINDS[kind].label);
    for (const option of options) {
      const { least, most } = KINDS[/** @type {Kind} */ (option.value)];
      assign(option, { textContent: labelOf(/** @type {Kind} */ (option.value)) });
      option.disabled = pins < least || pins > most;
    }
    const names = constraints.map(({ kind, handles }) =>
      [labelOf(kind), ...(kind === "Width" ? [] : [handles.map(([letter]) => nameOf(letter)).join(", ")])].join(": "));
    const state = JSON.stringify([names, constraints.map(({ value }) => value)]);
    if (state === shown) return;
    shown = state;
    element.replaceChildren(...constraints.map(({ value }, i) => chip(names[i], i, value)));
  }

  /** @param {string} name @param {number} index @param {number} [value] */
  function chip(name, index, value) {
    const remove = html("button", { type: "button", "aria-label": `Remove: ${name}`, title: "Remove", onclick: () => actions.remove(index) }, "×");
    if (value === undefined) return html("span", { class: "vfw-constraint" }, name, remove);
    const input = html("input", {
      type: "number", min: 0, step: "any", value: Math.round(value * 10) / 10, "aria-label": `${name}, font units`, [KEEP_KEYS]: "true",
      onchange: () => input.valueAsNumber >= 0 && actions.change(index, input.valueAsNumber),
    });
    return html("span", { class: "vfw-constraint" }, name, input, remove);
  }

  return { menu: adding, element, show };
}
