/** Views on a page without a kernel: the state of each lies in the page as JSON. */

export const STATE = "application/vnd.vfwidget+json";

/** A model with nobody at the other end: it keeps what it is given, and has no `send`. */
export class Model {
  /** @param {Record<string, any>} state */
  constructor(state) {
    this.state = state;
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
  on() {}
  off() {}
}

/** Puts a view after each state of the page. @param {(context: {model: any, el: HTMLElement}) => unknown} render */
export function mountAll(render) {
  for (const script of document.querySelectorAll(`script[type="${STATE}"]`)) {
    const el = document.createElement("div");
    script.after(el);
    render({ model: new Model(JSON.parse(script.textContent ?? "")), el });
  }
}
