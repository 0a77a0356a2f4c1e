/** Teaching mode: which axes move the selected letter, the scalars of its delta sets, and Eq. 1 with numbers. */
import { html } from "../view/dom.js";
import { normalize } from "../word/axes.js";
import { final, interpolate } from "../word/forward.js";
import { scalars } from "../word/regions.js";
import { blend, within } from "../word/positions.js";
import { evaluate } from "../word/varying.js";

/** @typedef {import("../word/forward.js").Layout} Layout @typedef {import("../word/decode.js").Word} Word @typedef {import("../word/decode.js").Glyph} Glyph */

const PARTS = "The outline is put together from other glyphs, so Eq. 1 holds for each of them.";
const POINT = "Press a point of the outline to see its numbers.";
/** Places on an axis that are looked at in addition to the kinks. */
const SAMPLES = 32;

const signed = (/** @type {number} */ v, digits = 1) => v.toFixed(digits).replace("-", "−");

/** A name, a bar and a number. @param {string} name @param {string} title */
function gauge(name, title) {
  const bar = html("meter", { min: 0, max: 1 }), number = html("output");
  const element = html("label", { class: "vfw-gauge", title }, html("span", {}, name), bar, number);
  return {
    element,
    show(/** @type {number} */ part, /** @type {string} */ text) {
      bar.value = part;
      number.textContent = text;
      element.toggleAttribute("data-zero", part === 0);
    },
  };
}

/** The outline of a glyph at normalized coordinates. @param {Word} word @param {Glyph} glyph @param {Float64Array} w */
function outline(word, glyph, w) {
  const { regions } = word, place = final(word, w);
  if (glyph.outline) return evaluate(glyph.outline, regions, place);
  return interpolate(glyph, scalars(regions, place, new Float64Array(regions.count)), new Float64Array(2 * glyph.k));
}

/**
 * How far each axis moves a glyph while the others stay at their defaults, in font units: as `Font.axis_effect`.
 * @param {Word} word @param {Glyph} glyph
 */
export function axisEffect(word, glyph) {
  const { axes, regions: { axis, start, peak, end } } = word, home = outline(word, glyph, new Float64Array(axes.length));
  return axes.map((one, i) => {
    const low = normalize(one, one.minimum), high = normalize(one, one.maximum);
    const kinks = [...axis].flatMap((a, k) => (a === i ? [start[k], peak[k], end[k]] : [])).filter((w) => w > low && w < high);
    const samples = Array.from({ length: SAMPLES + 1 }, (_, k) => low + (k / SAMPLES) * (high - low));
    let most = 0;
    for (const value of [...kinks, ...samples]) {
      const w = new Float64Array(axes.length);
      w[i] = value;
      const points = outline(word, glyph, w);
      for (let p = 0; p < points.length; p += 2) most = Math.max(most, Math.hypot(points[p] - home[p], points[p + 1] - home[p + 1]));
    }
    return most;
  });
}

export class Lesson {
  #glyph; #axes; #sets; #sums; #effects; #gauges;

  constructor() {
    /** @type {Glyph | null} */
    this.#glyph = null;
    const part = (/** @type {string} */ title, /** @type {Node} */ body) => html("section", {}, html("h4", {}, title), body);
    const list = (/** @type {string} */ label) => html("div", { class: "vfw-gauges", tabindex: 0, role: "group", "aria-label": label });
    this.#axes = list("Axes");
    this.#sets = list("Delta sets");
    this.#sums = html("div", { class: "vfw-sums", tabindex: 0, role: "group", "aria-label": "Equation" });
    /** @type {ReturnType<typeof gauge>[]} */
    this.#gauges = [];
    this.#effects = html("h4");
    this.element = html("div", { class: "vfw-lesson" },
      html("section", {}, this.#effects, this.#axes),
      part("Scalars γ of the delta sets Δ", this.#sets),
      part("Eq. 1 with numbers: p = p̄ + Σ γ · Δ", this.#sums));
  }

  /**
   * @param {Layout} layout @param {number} letter @param {string} name what the letter is called
   * @param {import("../word/forward.js").Handle | null} handle the point whose numbers are shown
   */
  show(layout, letter, name, handle) {
    const { word } = layout, glyph = layout.glyphs[letter], gamma = layout.gammas[layout.gammas.length > 1 ? letter : 0];
    if (!glyph) return;
    if (glyph !== this.#glyph) this.#begin(word, glyph, name);
    this.#gauges.forEach(({ show }, j) => show(gamma[glyph.regions[j]], signed(gamma[glyph.regions[j]], 3)));
    this.#sums.replaceChildren(...glyph.outline ? [PARTS] : handle?.[0] === letter ? this.#equations(glyph, gamma, handle) : [POINT]);
  }

  /** @param {Word} word @param {Glyph} glyph @param {string} name */
  #begin(word, glyph, name) {
    this.#glyph = glyph;
    const effects = axisEffect(word, glyph), most = Math.max(...effects, 1e-9);
    this.#effects.textContent = `How far each axis moves “${name}”, in font units`;
    this.#axes.replaceChildren(...word.axes.map((axis, i) => {
      const { element, show } = gauge(axis.name, axis.tag);
      show(effects[i] / most, signed(effects[i], 0));
      return element;
    }));
    const { first, axis, start, peak, end } = word.regions;
    this.#gauges = (glyph.outline ? [] : glyph.regions).map((j) => {
      const entries = Array.from({ length: first[j + 1] - first[j] }, (_, i) => first[j] + i);
      const say = (/** @type {(i: number) => string} */ value) => entries.map((i) => `${word.axes[axis[i]].tag} ${value(i)}`).join(", ");
      return gauge(say((i) => signed(peak[i], 2)), say((i) => `${signed(start[i], 2)} to ${signed(end[i], 2)}, peak ${signed(peak[i], 2)}`));
    });
    this.#sets.replaceChildren(...this.#gauges.map(({ element }) => element));
    if (glyph.outline) this.#sets.textContent = PARTS;
  }

  /** Eq. 1 for one point of the letter, relative to the letter's origin. @param {Glyph} glyph @param {Float64Array} gamma @param {any} handle */
  #equations(glyph, gamma, handle) {
    const forms = within(glyph, blend(glyph, handle));
    return ["x", "y"].map((name) => {
      const form = forms[/** @type {"x" | "y"} */ (name)];
      const terms = form.regions.map((region, j) => ({ g: gamma[region], d: form.deltas[j] })).filter(({ g, d }) => g !== 0 && Math.abs(d) >= 0.05);
      const sum = terms.reduce((total, { g, d }) => total + g * d, form.default);
      return html("code", {}, [`${name} = ${signed(form.default)}`,
        ...terms.map(({ g, d }) => `${d < 0 ? "−" : "+"} ${g.toFixed(3)} · ${Math.abs(d).toFixed(1)}`),
        ...terms.length ? [`= ${signed(sum)}`] : []].join(" "));
    });
  }
}
