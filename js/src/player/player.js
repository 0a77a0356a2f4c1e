/** One view of an animation: the picture, its controls, and the axes over time. It plays without a kernel. */
import { attr, html, icon, KEEP_KEYS } from "../view/dom.js";
import { decodeWord } from "../word/decode.js";
import { Curves } from "./curves.js";
import { advanced, decodeFilm, frameAt } from "./film.js";
import { Scene } from "./scene.js";

const PLAY = "M5 3.2v9.6l8-4.8z", PAUSE = "M5.2 3.5v9M10.8 3.5v9";
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const ONIONS = [0, 1, 3, 6, 10];
const TRAITS = ["_word", "_film", "playing", "time", "speed", "loop", "onion", "height", "theme", "error"];

const reduced = () => globalThis.matchMedia?.("(prefers-reduced-motion: reduce)").matches ?? false;

export class Player {
  /** @param {any} model anywidget's, or that of a page without a kernel */
  constructor(model) {
    this.model = model;
    /** Seconds. */
    this.time = 0;
    this.playing = false;
    this.last = this.frame = 0;
    /** @type {Scene | null} */
    this.scene = null;
    /** @type {Curves | null} */
    this.curves = null;

    this.button = html("button", { type: "button", class: "vfw-tool vfw-play", onclick: () => this.toggle() });
    this.slider = html("input", {
      type: "range", class: "vfw-time", min: 0, step: "any", value: 0, "aria-label": "Time",
      oninput: () => this.seek(this.slider.valueAsNumber), onchange: () => this.save({ time: this.time }),
    });
    this.clock = html("span", { class: "vfw-clock" });
    this.loop = html("input", { type: "checkbox", class: "vfw-loop", onchange: () => this.save({ loop: this.loop.checked }) });
    this.speed = this.choice("vfw-speed", "speed", SPEEDS, (v) => `${v}×`);
    this.onion = this.choice("vfw-onion", "onion", ONIONS, String);
    this.stage = html("div", { class: "vfw-stage" });
    this.below = html("div", {});
    this.line = html("div", { class: "vfw-status", role: "alert", hidden: true });
    this.root = html("div", {
      class: "vfwidget vfwidget-player", role: "group", [KEEP_KEYS]: "true",
      onkeydown: (/** @type {KeyboardEvent} */ event) => this.key(event),
    }, this.stage,
    html("div", { class: "vfw-controls" }, this.button, this.slider, this.clock,
      html("label", { class: "vfw-switch" }, this.loop, html("span", {}, "Loop")),
      html("label", { class: "vfw-switch" }, html("span", {}, "Speed"), this.speed),
      html("label", { class: "vfw-switch" }, html("span", {}, "Onion skin"), this.onion)),
    this.below, this.line);

    // The picture that a saved notebook shows is hidden while there is a live view.
    const snapshot = String(model.get("_snapshot") ?? "");
    if (/^[0-9a-f]+$/.test(snapshot)) this.root.append(html("style", {}, `.vfw-snapshot-${snapshot} { display: none }`));

    /** @type {[string, () => void][]} */
    this.listeners = TRAITS.map((trait) => [`change:${trait}`, () => this.guard(() => this.read(trait))]);
    for (const [name, listener] of this.listeners) model.on(name, listener);
    this.guard(() => {
      this.load();
      for (const trait of TRAITS.slice(2)) this.read(trait);
    });
    // Nothing starts by itself for a person who prefers reduced motion.
    if (this.playing && reduced()) this.save({ playing: false });
    Object.assign(this.root, { __vfw: { seek: (/** @type {number} */ time) => this.seek(time), state: () => ({ time: this.time, playing: this.playing }) } });
  }

  /**
   * A menu of numbers.
   * @private @param {string} name @param {string} trait @param {number[]} values @param {(value: number) => string} text
   */
  choice(name, trait, values, text) {
    const element = html("select", { class: name, onchange: () => this.save({ [trait]: Number(element.value) }) },
      ...values.map((value) => html("option", { value }, text(value))));
    return element;
  }

  /** Runs something; an error is shown and kills nothing. @private @param {() => void} action */
  guard(action) {
    try {
      action();
    } catch (error) {
      this.playing = false;
      this.say(/** @type {Error} */ (error).message || String(error));
    }
  }

  /** @private @param {string} text */
  say(text) {
    this.line.hidden = text === "";
    this.line.textContent = text;
  }

  /** Reads word and frames. @private */
  load() {
    const word = decodeWord(this.model.get("_word")), film = decodeFilm(this.model.get("_film"), word);
    this.scene = new Scene(word, film);
    this.curves = new Curves(word, film, (time, done) => {
      this.seek(time);
      if (done) this.save({ time: this.time });
    });
    this.stage.replaceChildren(this.scene.element);
    this.below.replaceChildren(this.curves.element);
    attr(this.root, "aria-label", `Animation of ${word.string}`);
    this.slider.max = String(film.duration);
    this.time = Math.min(this.time, film.duration);
    this.say("");
    this.draw();
  }

  /** @private @param {string} trait */
  read(trait) {
    const value = this.model.get(trait);
    if (trait === "_word" || trait === "_film") this.load();
    else if (trait === "time") {
      if (Number.isFinite(value) && value !== this.time) this.move(value);
    } else if (trait === "playing") this.run(value === true);
    else if (trait === "loop") this.loop.checked = value !== false;
    else if (trait === "speed") this.select(this.speed, value, (v) => `${v}×`);
    else if (trait === "onion") {
      this.select(this.onion, value, String);
      this.draw();
    } else if (trait === "error") this.say(String(value ?? ""));
    else if (trait === "theme") attr(this.root, "data-theme", value ?? "auto");
    else if (trait === "height") {
      if (Number.isFinite(value)) this.root.style.setProperty("--vfw-height", `${value}px`);
      else this.root.style.removeProperty("--vfw-height");
    }
  }

  /** @private @param {HTMLSelectElement} menu @param {number} value @param {(value: number) => string} text */
  select(menu, value, text) {
    if (!Number.isFinite(value)) return;
    if (![...menu.options].some((option) => Number(option.value) === value)) menu.append(html("option", { value }, text(value)));
    menu.value = String(value);
  }

  /** Changes traits; without a kernel they stay in this view. @private @param {Record<string, unknown>} traits */
  save(traits) {
    for (const [name, value] of Object.entries(traits)) this.model.set(name, value);
    for (const name of Object.keys(traits)) this.guard(() => this.read(name));
    try {
      this.model.save_changes();
    } catch {
      // The kernel is gone; the animation goes on.
    }
  }

  toggle() {
    const { duration } = this.scene?.film ?? { duration: 0 };
    const playing = !this.playing;
    if (playing && this.time >= duration) this.move(0);
    this.save({ playing, time: this.time });
  }

  /** Starts or stops the clock. @private @param {boolean} playing */
  run(playing) {
    const began = playing && !this.playing;
    this.playing = playing && this.scene !== null;
    const label = this.playing ? "Pause" : "Play";
    attr(this.button, "aria-label", label);
    this.button.title = `${label} (Space)`;
    this.button.replaceChildren(icon(this.playing ? PAUSE : PLAY));
    if (began && this.playing) {
      this.last = performance.now();
      this.frame = requestAnimationFrame((now) => this.tick(now));
    }
  }

  /** @private @param {number} now */
  tick(now) {
    if (!this.playing || this.scene === null) return;
    const { film } = this.scene, elapsed = Math.max(0, now - this.last) / 1000 * (Number(this.speed.value) || 1);
    this.last = now;
    const { time, ended } = advanced(this.time + elapsed, film.duration, this.loop.checked);
    this.guard(() => this.move(time));
    if (ended) this.save({ playing: false, time });
    else this.frame = requestAnimationFrame((next) => this.tick(next));
  }

  /** Goes to a time at a person's wish, and stays there. @param {number} time */
  seek(time) {
    if (this.playing) this.save({ playing: false });
    this.guard(() => this.move(time));
  }

  /** @private @param {number} time */
  move(time) {
    this.time = Math.min(Math.max(0, time), this.scene?.film.duration ?? 0);
    this.draw();
  }

  /** @private */
  draw() {
    if (this.scene === null || this.curves === null) return;
    const { film } = this.scene;
    this.scene.draw(this.time, Math.min(Number(this.onion.value) || 0, 20));
    this.curves.show(this.time, frameAt(film, this.time));
    this.slider.value = String(this.time);
    this.clock.textContent = `${this.time.toFixed(2)} / ${film.duration.toFixed(2)} s`;
    attr(this.slider, "aria-valuetext", `${this.time.toFixed(2)} seconds`);
  }

  /** @private @param {KeyboardEvent} event */
  key(event) {
    const target = /** @type {HTMLElement} */ (event.target);
    if (event.ctrlKey || event.metaKey || event.altKey || this.scene === null) return;
    const { film } = this.scene, frame = frameAt(film, this.time), last = film.times.length - 1;
    const to = (/** @type {number} */ index) => () => {
      this.seek(film.times[Math.min(last, Math.max(0, index))]);
      this.save({ time: this.time });
    };
    /** @type {Record<string, () => void>} */
    const keys = {
      ArrowLeft: to(this.time > film.times[frame] + 1e-9 ? frame : frame - 1), ArrowRight: to(frame + 1),
      Home: to(0), End: to(last), l: () => this.save({ loop: !this.loop.checked }),
    };
    if (!target.matches("button, input[type=checkbox]")) keys[" "] = () => this.toggle();
    const action = keys[event.key];
    if (action === undefined || target.matches("select")) return;
    event.preventDefault();
    event.stopPropagation();
    action();
  }

  destroy() {
    this.playing = false;
    cancelAnimationFrame(this.frame);
    for (const [name, listener] of this.listeners) this.model.off(name, listener);
  }
}
