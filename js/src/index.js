/** The anywidget module of the editor. */
import { createEditor } from "./editor/editor.js";

/** Asks the kernel for the parts that are not in this script. @param {any} model @returns {Promise<typeof import("./tools.js")>} */
const tools = (model) => new Promise((resolve, reject) => {
  const receive = (/** @type {any} */ { type, script }) => {
    if (type !== "tools") return;
    model.off("msg:custom", receive);
    import(URL.createObjectURL(new Blob([script], { type: "text/javascript" }))).then(resolve, reject);
  };
  model.on("msg:custom", receive);
  model.send({ type: "tools" });
});

/** @param {{model: any, el: HTMLElement}} context */
function render({ model, el }) {
  const editor = createEditor(model, tools(model));
  el.append(editor.root);
  return () => editor.destroy();
}

export default { render };
