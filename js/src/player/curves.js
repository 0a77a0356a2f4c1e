/**
 * The axes over time: one colour for each axis, one line for each axis vector, and a line at the present time. All have
 * one scale: the middle is the default, and the top and the bottom are the ends of each range.
 */
import { attr, html, svg } from "../view/dom.js";
import { varying } from "./film.js";

const WIDTH = 300, HEIGHT = 60;

/** Hues that remain apart for most kinds of colour blindness. */
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

export class Curves {
  /**
   * @param {import("../word/decode.js").Word} word @param {import("./film.js").Film} film
   * @param {(time: number, done: boolean) => void} seek
   */
  constructor(word, film, seek) {
    this.film = film;
    this.word = word;
    this.axes = varying(film, word);
    this.now = svg("line", { class: "vfw-now", y1: 0, y2: HEIGHT });
    this.chart = svg("svg", {
      class: "vfw-chart", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", "aria-hidden": "true",
      onpointerdown: (/** @type {PointerEvent} */ event) => {
        this.chart.setPointerCapture(event.pointerId);
        seek(this.timeAt(event), false);
      },
      onpointerup: (/** @type {PointerEvent} */ event) => seek(this.timeAt(event), true),
      onpointermove: (/** @type {PointerEvent} */ event) => {
        if (event.buttons & 1) seek(this.timeAt(event), false);
      },
    }, svg("title", {}, "Top: maximum of each axis. Middle: default. Bottom: minimum."),
    svg("line", { class: "vfw-default", x1: 0, x2: WIDTH, y1: HEIGHT / 2, y2: HEIGHT / 2 }),
    ...this.axes.flatMap((axis, i) => this.lines(axis, COLOURS[i % COLOURS.length])), this.now);
    this.values = this.axes.map(() => html("output", {}));
    this.element = html("div", { class: "vfw-curves", hidden: this.axes.length === 0 }, this.chart,
      html("ul", { class: "vfw-legend" }, ...this.axes.map((axis, i) => html("li", {},
        html("span", { class: "vfw-swatch", style: `background: ${COLOURS[i % COLOURS.length]}` }),
        `${word.axes[axis].name} `, this.values[i]))));
  }

  /** @private @param {PointerEvent} event */
  timeAt(event) {
    const { left, width } = this.chart.getBoundingClientRect();
    return Math.min(1, Math.max(0, (event.clientX - left) / (width || 1))) * this.film.duration;
  }

  /** @private @param {number} axis @param {string} colour */
  lines(axis, colour) {
    const { times, axes, vectors, duration } = this.film, n = this.word.axes.length;
    const { minimum, default: middle, maximum } = this.word.axes[axis];
    return Array.from({ length: vectors }, (_, v) => svg("polyline", {
      class: "vfw-curve", stroke: colour,
      points: times.map((time, f) => {
        const value = axes[(f * vectors + v) * n + axis] - middle;
        const y = HEIGHT / 2 - (HEIGHT / 2 - 4) * value / ((value < 0 ? middle - minimum : maximum - middle) || 1);
        return `${(WIDTH * time / (duration || 1)).toFixed(1)},${y.toFixed(1)}`;
      }).join(" "),
    }));
  }

  /** @param {number} time @param {number} frame */
  show(time, frame) {
    const x = WIDTH * time / (this.film.duration || 1);
    attr(this.now, "x1", x);
    attr(this.now, "x2", x);
    const { axes, vectors } = this.film, n = this.word.axes.length;
    this.axes.forEach((axis, i) => {
      const all = Array.from({ length: vectors }, (_, v) => axes[(frame * vectors + v) * n + axis]);
      const text = [Math.min(...all), Math.max(...all)].map((v) => String(Number(v.toPrecision(4))));
      this.values[i].textContent = text[0] === text[1] ? text[0] : `${text[0]} … ${text[1]}`;
    });
  }
}
