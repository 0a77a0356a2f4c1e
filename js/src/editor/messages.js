/** What the editor says: hints, the result of a drag, and the state of the kernel. */

/** @typedef {import("../solver/drag.js").Place} Place */

export const HINT = "Drag the outline to change the font. Click the outline to pin a point.";
export const KEYS = "Press Page Down to select the next point, the arrow keys to move it, and Enter to pin it.";
export const BUSY = "The kernel is busy or has stopped. The editor goes on by itself and sends its state when the kernel answers.";
export const UNSENT = "The editor has lost its kernel. Run its cell again to reconnect it; until then Python does not see your changes.";

/**
 * The result of a drag: whether the goal is met, and if not, what stands in the way.
 * @param {Place} place @param {import("./session.js").Session} session
 */
export function placeInWords({ met, missing, held }, { word, shared }) {
  if (met) return "The point has reached the pointer.";
  const ends = held.map(({ axis, letter, end }) =>
    `${word?.axes[axis].name}${shared ? "" : ` of letter ${letter + 1}`} is at its ${end > 0 ? "maximum" : "minimum"}`);
  const distance = `The font cannot reach the pointer: ${missing.toFixed(missing < 10 ? 1 : 0)} font units remain.`;
  return ends.length > 0 ? `${distance} ${listed(ends)}.` : distance;
}

/** A list in words. @param {string[]} items */
const listed = (items) => (items.length > 1 ? `${items.slice(0, -1).join(", ")} and ${items[items.length - 1]}` : items[0]);
