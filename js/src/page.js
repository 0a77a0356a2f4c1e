/** Views on a page without a kernel: the state of each lies in the page as JSON. */

export const STATE = "application/vnd.vfwidget+json";

/** Stands in for the kernel: keeps the traits, and accepts the drags as the view has solved them. */
export class Model {
  /** @param {Record<string, any>} state */
  constructor(state) {
    this.state = state;
    /** @type {Map<string, Set<(value: any) => void>>} */
    this.listeners = new Map();
  }

  /** @param {string} name */
  get(name) {
    return this.state[name];
  }

  /** @param {string} name @param {any} value */
  set(name, value) {
    this.state[name] = value;
  }

  save_changes() {}

  /** @param {string} event @param {(value: any) => void} listener */
  on(event, listener) {
    this.listeners.set(event, (this.listeners.get(event) ?? new Set()).add(listener));
  }

  /** @param {string} event @param {(value: any) => void} listener */
  off(event, listener) {
    this.listeners.get(event)?.delete(listener);
  }

  /** @param {any} message of a view */
  send({ type, view, seq, axes }) {
    this.state.axes = axes;
    for (const listener of this.listeners.get("msg:custom") ?? []) listener({ type, view, seq, ok: true, axes });
  }
}

/** Puts a view after each state of the page. @param {(context: {model: any, el: HTMLElement}) => unknown} render */
export function mountAll(render) {
  for (const script of document.querySelectorAll(`script[type="${STATE}"]`)) {
    const el = document.createElement("div");
    script.after(el);
    render({ model: new Model(JSON.parse(script.textContent ?? "")), el });
  }
}
