/**
 * A word as SVG: its letters, its baseline and the window onto them. Knows nothing of editing, so
 * whatever has a word and axis values can show it.
 */
import { layers } from "./colour.js";
import { attr, svg } from "./dom.js";
import { pathData, round } from "./path.js";
import { Layout } from "../word/forward.js";

/** @typedef {{x: number, y: number, width: number, height: number}} Box  font units, y down as SVG has it */

/** The window is at most this many times smaller, or larger, than one that fits the word. */
const MOST = 40;

/** The window that shows a laid-out word, or a box around it, with room on all sides. @param {Layout} layout @returns {Box} */
export function windowFor(layout, [left, bottom, right, top] = layout.box()) {
  const { ascender, descender, unitsPerEm } = layout.word;
  const low = Math.min(bottom, descender), high = Math.max(top, ascender);
  const padX = 0.06 * (right - left) + 0.12 * unitsPerEm, padY = 0.07 * (high - low);
  return { x: left - padX, y: -high - padY, width: right - left + 2 * padX, height: high - low + 2 * padY };
}

export class Drawing {
  #baseline; #animation; #colours; #letters; #row; #window;

  constructor() {
    this.#baseline = svg("line", { class: "vfw-baseline", x1: -1e5, x2: 1e5, y1: 0, y2: 0 });
    /** What lies behind the word; its path data is for others to set. */
    this.backdrop = svg("path", { class: "vfw-obstacles" });
    this.#letters = svg("g", { class: "vfw-letters" });
    this.#colours = svg("g", { class: "vfw-colours" });
    /** For whoever draws on top of the word. */
    this.overlay = svg("g", { class: "vfw-overlay" });
    this.svg = svg("svg", { class: "vfw-svg", preserveAspectRatio: "xMidYMid meet" },
      this.#baseline, this.backdrop, this.#colours, this.#letters, this.overlay);
    /** @type {Layout | null} */
    this.layout = null;
    /** The row of glyphs that the paths are for. @type {import("../word/rows.js").Row | null} */
    this.#row = null;
    /** @type {Box} */
    this.#window = { x: 0, y: -1000, width: 1000, height: 1000 };
    this.#animation = 0;
    /** Whether the window was chosen by hand, and so does not fit itself to the word. */
    this.chosen = false;
    /** Called while the window moves. @type {() => void} */
    this.onmove = () => {};
  }

  /**
   * What the window shows: the word, and what lies behind it up to an em away. Artwork may be far larger than the word.
   * @returns {[left: number, bottom: number, right: number, top: number]}
   */
  get #box() {
    const layout = /** @type {Layout} */ (this.layout);
    const [left, bottom, right, top] = layout.box(), em = layout.word.unitsPerEm, { x, y, width, height } = this.backdrop.getBBox();
    const least = (/** @type {number} */ own, /** @type {number} */ behind) => Math.min(own, Math.max(behind, own - em));
    return [least(left, x), least(bottom, -y - height), -least(-right, -x - width), -least(-top, y)];
  }

  /** The window that shows all of it. */
  get #wanted() {
    return windowFor(/** @type {Layout} */ (this.layout), this.#box);
  }

  /** @param {import("../word/decode.js").Word} word @param {any} axes user values, as Layout.evaluate takes them */
  setWord(word, axes) {
    this.layout = new Layout(word).evaluate(axes);
    this.#place(this.layout);
    this.chosen = false;
    this.show(this.#wanted);
  }

  /** A path for each letter. @param {Layout} layout */
  #place({ row }) {
    this.#row = row;
    this.#letters.replaceChildren(...row.order.map((_, i) =>
      svg("path", { class: "vfw-letter", "data-letter": i, "fill-rule": "nonzero" })));
  }

  /** @param {any} axes */
  draw(axes) {
    if (this.layout === null) return;
    if (this.layout.evaluate(axes).row !== this.#row) this.#place(this.layout);
    const paths = this.#letters.children;
    const colours = [];
    for (let i = 0; i < paths.length; i++) {
      const place = { transform: `translate(${round(this.layout.x[i])} ${round(-this.layout.y[i])})` };
      // Long, and hardly ever the same: not worth a comparison.
      paths[i].setAttribute("d", pathData(this.layout, i));
      attr(paths[i], "transform", place.transform);
      // A colour glyph is pressed by its own outline, which is not seen.
      attr(paths[i], "fill-opacity", this.layout.glyphs[i].layers.length ? "0" : "1");
      colours.push(svg("g", place, ...layers(this.layout, i)));
    }
    this.#colours.replaceChildren(...colours.filter((group) => group.childNodes.length));
  }

  /**
   * The greatest distance between the control points of the word at two places, in font units.
   * @param {any} axes @param {any} others
   */
  distance(axes, others) {
    if (this.layout === null) return 0;
    const { word } = this.layout, a = new Layout(word).evaluate(axes), b = new Layout(word).evaluate(others);
    if (a.key !== b.key) return Infinity;
    let most = 0;
    a.points.forEach((points, letter) => {
      const x = a.x[letter] - b.x[letter], y = a.y[letter] - b.y[letter], twin = b.points[letter];
      for (let i = 0; i < points.length; i += 2) {
        most = Math.max(most, Math.hypot(points[i] - twin[i] + x, points[i + 1] - twin[i + 1] + y));
      }
    });
    return most;
  }

  /** @param {Box} box */
  show(box) {
    this.#window = box;
    attr(this.svg, "viewBox", `${box.x} ${box.y} ${box.width} ${box.height}`);
  }

  /** Pixels a font unit would take in a window. @param {Box} box */
  #scale(box) {
    const { width, height } = this.svg.getBoundingClientRect();
    return Math.min(width / box.width, height / box.height);
  }

  /** The part of the plane that is shown: the window, extended to the shape of the element. @returns {Box} */
  get #visible() {
    const { x, y, width, height } = this.#window, scale = this.#scale(this.#window);
    if (!(scale > 0)) return this.#window; // not on the page
    const rect = this.svg.getBoundingClientRect(), w = rect.width / scale, h = rect.height / scale;
    return { x: x - (w - width) / 2, y: y - (h - height) / 2, width: w, height: h };
  }

  /** Shows things larger by a factor; a place in word coordinates stays where it is. @param {number} factor @param {[number, number]} place */
  zoom(factor, [x, y]) {
    if (this.layout === null || !Number.isFinite(x + y)) return;
    const from = this.#visible, { width } = windowFor(this.layout);
    const part = Math.min(width * MOST, Math.max(width / MOST, from.width / factor)) / from.width;
    this.hold();
    this.show({
      x: x - part * (x - from.x), y: -y - part * (-y - from.y), width: part * from.width, height: part * from.height,
    });
  }

  /** Moves the picture by so many pixels, to the right and down. @param {number} dx @param {number} dy */
  pan(dx, dy) {
    const { x, y, width, height } = this.#visible, { pixel } = this;
    this.hold();
    this.show({ x: x - dx * pixel, y: y - dy * pixel, width, height });
  }

  /** Makes room when a drag moves the word out of the picture; what is under the pointer stays there. @param {[number, number]} place */
  follow([x, y]) {
    if (this.layout === null || this.chosen) return;
    const { x: left, y: top, width, height } = this.#visible, [l, b, r, t] = this.layout.box();
    const room = [x - left, left + width - x, y + top + height, -top - y], wanted = [x - l, r - x, y - b, t - y];
    // A pointer that has left the picture leaves no room to zoom about it.
    if (room.some((v, i) => !(v > width / 50) && wanted[i] > v)) return;
    const most = Math.max(...wanted.map((v, i) => v / Math.max(room[i], 1e-9)));
    if (most > 0.98) this.zoom(0.96 / most, [x, y]);
  }

  /** Does the word leave the picture, sit far from its middle, or look lost in it? A window that was chosen by hand always fits. */
  get fits() {
    if (this.layout === null || this.chosen) return true;
    const now = this.#scale(this.#window);
    if (!(now > 0)) return true; // not on the page
    const shown = this.#visible, wanted = this.#wanted, [left, bottom, right, top] = this.#box;
    const inside = left >= shown.x && right <= shown.x + shown.width && -top >= shown.y && -bottom <= shown.y + shown.height;
    const shift = Math.abs(wanted.x + wanted.width / 2 - shown.x - shown.width / 2);
    return inside && shift < 0.15 * shown.width && this.#scale(wanted) < 1.35 * now;
  }

  /** Moves the window to where the word is now. @param {boolean} [still] at once, without an animation; by default if the user prefers less motion */
  fit(still = globalThis.matchMedia?.("(prefers-reduced-motion: reduce)").matches) {
    if (this.layout === null) return;
    const from = this.#window, to = this.#wanted, began = performance.now();
    this.hold();
    this.chosen = false;
    if (still) {
      this.show(to);
      return this.onmove();
    }
    const step = (/** @type {number} */ now) => {
      const part = Math.min(1, Math.max(0, (now - began) / 240)), ease = 1 - (1 - part) ** 3;
      const mix = (/** @type {keyof Box} */ key) => from[key] + ease * (to[key] - from[key]);
      this.show({ x: mix("x"), y: mix("y"), width: mix("width"), height: mix("height") });
      this.#animation = part < 1 ? requestAnimationFrame(step) : 0;
      this.onmove();
    };
    this.#animation = requestAnimationFrame(step);
  }

  /** Stops a window in motion: nothing may slide away under a pressed pointer. */
  hold() {
    cancelAnimationFrame(this.#animation);
    this.#animation = 0;
  }

  /** Word coordinates of a place on the page; NaN while the picture is not shown. @param {number} x @param {number} y */
  toFont(x, y) {
    const matrix = this.svg.getScreenCTM();
    if (!matrix?.a) return { x: NaN, y: NaN };
    const point = new DOMPoint(x, y).matrixTransform(matrix.inverse());
    return { x: point.x, y: -point.y };
  }

  /** The place on the page of word coordinates. @param {number} x @param {number} y */
  toClient(x, y) {
    const matrix = this.svg.getScreenCTM();
    if (!matrix?.a) return { x: NaN, y: NaN };
    const point = new DOMPoint(x, -y).matrixTransform(matrix);
    return { x: point.x, y: point.y };
  }

  /** Font units a pixel takes. */
  get pixel() {
    return 1 / (this.svg.getScreenCTM()?.a || 1);
  }
}
