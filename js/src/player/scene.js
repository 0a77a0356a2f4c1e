/** The picture: the letters at a time, those of a few frames before as outlines, and the obstacles. */
import { layers } from "../view/colour.js";
import { pathData } from "../view/path.js";
import { attr, svg } from "../view/dom.js";
import { Layout } from "../word/forward.js";
import { stateAt } from "./film.js";

/** Frames between two outlines of the onion skin. */
const STEP = 3;

const round = (/** @type {number} */ v) => Math.round(v * 100) / 100;

export class Scene {
  /** @param {import("../word/decode.js").Word} word @param {import("./film.js").Film} film */
  constructor(word, film) {
    this.word = word;
    this.film = film;
    this.layout = new Layout(word);
    const [left, bottom, right, top] = film.box;
    this.obstacle = svg("path", { class: "vfw-obstacle" });
    this.ghosts = svg("g", { class: "vfw-ghosts" });
    this.letters = svg("g", { class: "vfw-letters vfw-colours" });
    this.element = svg("svg", {
      class: "vfw-svg", role: "img", "aria-label": word.string, preserveAspectRatio: "xMidYMid meet",
      viewBox: [left, -top, right - left, top - bottom].map(round).join(" "),
    }, this.obstacle, this.ghosts, this.letters);
  }

  /** @param {number} time seconds @param {number} onion how many earlier frames show */
  draw(time, onion) {
    const { film } = this, frame = this.place(this.letters, "vfw-letter", time);
    attr(this.obstacle, "d", film.obstacles[film.scene[frame]] ?? "");
    const earlier = Array.from({ length: onion }, (_, i) => frame - STEP * (i + 1)).filter((i) => i >= 0);
    while (this.ghosts.childElementCount > earlier.length) this.ghosts.lastElementChild?.remove();
    earlier.forEach((index, i) => {
      if (!this.ghosts.children[i]) this.ghosts.append(svg("g", { opacity: round(0.8 * (1 - i / (onion + 1))) }));
      this.place(/** @type {SVGElement} */ (this.ghosts.children[i]), "vfw-ghost", film.times[index]);
    });
  }

  /** Draws the letters at a time into a group. @private @param {SVGElement} group @param {string} name @param {number} time */
  place(group, name, time) {
    const { layout, word } = this, state = stateAt(this.film, word, time);
    word.offsets = state.offsets;
    layout.evaluate(state.axes);
    const count = layout.row.order.length;
    while (group.childElementCount > count) group.lastElementChild?.remove();
    for (let i = 0; i < count; i++) {
      if (!group.children[i]) group.append(svg("g", {}, svg("path", { class: name, "fill-rule": "nonzero" })));
      const letter = group.children[i], path = letter.children[0], turn = -(state.rotations[i] ?? 0) * 180 / Math.PI;
      attr(letter, "transform", `translate(${round(layout.x[i])} ${round(-layout.y[i])}) rotate(${round(turn)})`);
      attr(path, "d", pathData(layout, i));
      // The outlines of the onion skin have no colours.
      const coloured = group === this.letters && layout.glyphs[i].layers.length > 0;
      attr(path, "fill-opacity", coloured ? "0" : "1");
      letter.replaceChildren(path, ...(coloured ? layers(layout, i) : []));
    }
    return state.frame;
  }
}
