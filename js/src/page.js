/** Editors on a page without a kernel: the state of each lies in the page as JSON. */
import { createEditor } from "./editor/editor.js";
import { Model } from "./editor/model.js";
import * as tools from "./tools.js";

const STATE = "application/vnd.vfwidget+json";

/** Puts an editor after each state of the page. */
export function mount() {
  for (const script of document.querySelectorAll(`script[type="${STATE}"]`)) {
    const model = new Model(JSON.parse(script.textContent ?? ""));
    script.after(createEditor(model, Promise.resolve(tools)).root);
  }
}
