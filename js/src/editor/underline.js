/** The lines under the letters that change together. No DOM. */

/** Between an underline and what is above it, in ems. */
const GAP = 0.07;

/**
 * Left, right and y of a line under some letters, one for each line of text that has any of them. Letters that follow each
 * other in the row need not do so in the text, and may be on several lines.
 * @param {import("../word/forward.js").Layout} layout @param {import("./session.js").Session} session
 * @returns {[number, number, number][]}
 */
export function underlines(layout, session) {
  if (session.shared) return [];
  /** @type {Map<number, [number, number, number]>} */
  const found = new Map();
  layout.row.lines.forEach((line, i) => {
    if (!session.chosen(i)) return;
    // A mark has no advance, only an outline.
    const xs = layout.advance[i] > 0 ? [0, layout.advance[i]] : [...layout.points[i]].filter((_, j) => j % 2 === 0);
    if (xs.length === 0) return;
    const [left, right, low] = found.get(line) ?? [Infinity, -Infinity, Infinity], x = layout.x[i];
    found.set(line, [Math.min(left, x + Math.min(...xs)), Math.max(right, x + Math.max(...xs)), Math.min(low, layout.bottom(i))]);
  });
  return [...found.values()].map(([left, right, low]) => [left, right, low - GAP * layout.word.unitsPerEm]);
}
