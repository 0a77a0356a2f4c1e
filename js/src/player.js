/** The anywidget module of the player. `mount` is for pages without a kernel. */
import { Player } from "./player/player.js";

export const STATE = "application/vnd.vfwidget.player+json";

/** @param {{model: any, el: HTMLElement}} context */
function render({ model, el }) {
  const player = new Player(model);
  el.append(player.root);
  return () => player.destroy();
}

/** Puts a player after each state of the page; the state stands in for a kernel's model. */
export function mount() {
  for (const script of document.querySelectorAll(`script[type="${STATE}"]`)) {
    const el = document.createElement("div"), state = JSON.parse(script.textContent ?? "");
    script.after(el);
    const model = {
      get: (/** @type {string} */ name) => state[name],
      set: (/** @type {string} */ name, /** @type {unknown} */ value) => { state[name] = value; },
      save_changes() {}, on() {}, off() {},
    };
    render({ model, el });
  }
}

export default { render };
