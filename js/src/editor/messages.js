/** What the editor says: hints, the result of a drag, and the state of the kernel. */

/** @typedef {import("../solver/drag.js").Place} Place */

export const HINT = "Drag the outline to change the font. Click the outline to pin a point.";
export const KEYS = "Press Page Down to select the next point, the arrow keys to move it, and Enter to pin it.";
export const BETTER = "Go to a closer result with very different axes";
export const BUSY = "The kernel is busy or has stopped. The editor goes on by itself and sends its state when the kernel answers.";
export const LATER = "This part of the editor has not arrived; the kernel sends it when it is free.";
export const REACH = "Press a point of the outline to see what it can reach.";
export const UNMET = "The font cannot meet all constraints; this is the nearest result.";
export const UNSENT = "The editor has lost its kernel. Run its cell again; until then Python does not see your changes.";

/**
 * The result of a drag: whether the goal is met, and if not, what stands in the way.
 * @param {Place} place @param {import("./session.js").Session} session
 */
export function placeInWords({ met, missing, held }, { word, shared }) {
  if (met) return "The point has reached the pointer.";
  const names = (/** @type {number} */ side) => held.filter(({ end }) => end === side)
    .map(({ axis, letter }) => `${word?.axes[axis].name}${shared ? "" : ` of letter ${letter + 1}`}`);
  const ends = [["maximum", names(1)], ["minimum", names(-1)]].filter(([, list]) => list.length > 0);
  const distance = `The font cannot reach the pointer: ${missing.toFixed(missing < 10 ? 1 : 0)} font units remain.`;
  return [distance, ...ends.map(([end, list]) => `At the ${end}: ${/** @type {string[]} */ (list).join(", ")}.`)].join(" ");
}
