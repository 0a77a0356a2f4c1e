/** The model of an editor on a page without a kernel. */
import { alike } from "../word/decode.js";

/** The traits that a step of undo brings back. */
const STEP = ["axes", "shared", "_pins", "locks", "constraints"];

/** Stands in for the kernel: keeps the traits and their history, and accepts drags as the view has solved them. */
export class Model {
  #state; #listeners; #past; #future; #gesture; #kept;

  /** @param {Record<string, any>} state */
  constructor(state) {
    this.#state = state;
    /** @type {Map<string, Set<(value: any) => void>>} */
    this.#listeners = new Map();
    /** @type {Record<string, any>[]} */
    this.#past = [];
    /** @type {Record<string, any>[]} */
    this.#future = [];
    this.#gesture = "";
    this.#kept = this.#step;
  }

  /** @param {string} name */
  get(name) {
    return this.#state[name];
  }

  /** @param {string} name @param {any} value */
  set(name, value) {
    this.#state[name] = value;
  }

  save_changes() {
    this.#record(this.#state._gesture);
  }

  /** The state that undo brings back. */
  get #step() {
    return Object.fromEntries(STEP.map((name) => [name, this.#state[name]]));
  }

  /** Keeps the state from before a change; one gesture is one step, and none if it changes nothing. @param {string} gesture */
  #record(gesture) {
    if (alike(this.#kept, this.#step)) return;
    if (gesture !== this.#gesture) {
      this.#past.push(this.#kept);
      this.#future = [];
    } else if (alike(this.#past[this.#past.length - 1], this.#step)) {
      this.#past.pop();
      gesture = "";
    }
    this.#gesture = gesture;
    this.#settle();
  }

  #settle() {
    this.#kept = this.#step;
    this.#state._steps = [this.#past.length, this.#future.length];
    this.#emit("change:_steps");
  }

  /** Goes from one end of the history to the other. @param {Record<string, any>[]} from @param {Record<string, any>[]} to */
  #move(from, to) {
    const step = from.pop();
    if (!step) return;
    to.push(this.#kept);
    Object.assign(this.#state, step);
    this.#settle();
    this.#announce();
  }

  #announce() {
    this.#gesture = "";
    for (const name of STEP) this.#emit(`change:${name}`);
  }

  /** @param {any} message of a view */
  send({ type, view, seq, gesture, axes }) {
    if (type === "undo") this.#move(this.#past, this.#future);
    else if (type === "redo") this.#move(this.#future, this.#past);
    else if (type === "restart" && this.#past.length > 0) {
      Object.assign(this.#state, this.#past[0]);
      this.#record(type);
      this.#announce();
    } else if (type === "drag") {
      this.#state.axes = axes;
      this.#record(gesture);
      this.#emit("msg:custom", { type, view, seq, ok: true, axes });
    }
  }

  /** @param {string} event @param {any} [value] */
  #emit(event, value) {
    for (const listener of this.#listeners.get(event) ?? []) listener(value);
  }

  /** @param {string} event @param {(value: any) => void} listener */
  on(event, listener) {
    this.#listeners.set(event, (this.#listeners.get(event) ?? new Set()).add(listener));
  }

  /** @param {string} event @param {(value: any) => void} listener */
  off(event, listener) {
    this.#listeners.get(event)?.delete(listener);
  }
}
