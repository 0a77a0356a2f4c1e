/** Parts of the editor that are not needed at once. A notebook does not store them with every editor. */
export { Lesson } from "./lesson/lesson.js";
export { Reach } from "./editor/reach.js";
export { save } from "./editor/save.js";
export { underlines } from "./editor/underline.js";
