/** The anywidget module: a view of the editor's model. `mount` is for pages without a kernel. */
import { Editor } from "./editor/editor.js";
import { mountAll } from "./page.js";

/** @param {{model: any, el: HTMLElement}} context */
function render({ model, el }) {
  const editor = new Editor(model);
  el.append(editor.root);
  return () => editor.destroy();
}

export const mount = () => mountAll(render);
export default { render };
