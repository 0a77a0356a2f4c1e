/** The anywidget module: a view of the editor's model. */
import { Editor } from "./editor.js";

/** @param {{model: any, el: HTMLElement}} context */
function render({ model, el }) {
  const editor = new Editor(model);
  el.append(editor.root);
  return () => editor.destroy();
}

export default { render };
