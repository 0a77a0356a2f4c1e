/** The places that a point can reach: goals on a grid are solved as drags, each from the result of a neighbour. No DOM. */

/** Goals that are tried at most. */
const MOST = 8000;

export class Reach {
  #drag; #origin; #spacing; #waiting; #seen;

  /**
   * @param {import("../solver/drag.js").Drag} drag @param {[number, number]} origin where the point is
   * @param {number} spacing of the grid, in font units
   */
  constructor(drag, origin, spacing) {
    this.#drag = drag;
    this.#origin = origin;
    this.#spacing = spacing;
    /** @type {[number, number, typeof drag.state][]} */
    this.#waiting = [[0, 0, drag.state]];
    this.#seen = new Set(["0,0"]);
    /** The places found so far, as path data of dots, and the width of a dot. */
    this.path = "";
    this.width = 1.5 * spacing;
  }

  /** Goes on for some time. @param {number} milliseconds @returns {boolean} whether there is more to do */
  grow(milliseconds) {
    const end = performance.now() + milliseconds, drag = this.#drag, [x, y] = this.#origin, size = this.#spacing;
    while (performance.now() < end) {
      const next = this.#waiting.shift();
      if (!next) return false;
      const [i, j, state] = next;
      drag.state = state;
      const { missing, point } = drag.to([x + i * size, y + j * size], milliseconds);
      this.path += `M${point[0].toFixed(1)} ${(-point[1]).toFixed(1)}h0`;
      // Beyond a place that is missed by more than a step there is no other one on this way.
      for (const [a, b] of missing > size ? [] : [[i + 1, j], [i - 1, j], [i, j + 1], [i, j - 1]]) {
        const key = `${a},${b}`;
        if (this.#seen.has(key) || this.#seen.size >= MOST) continue;
        this.#seen.add(key);
        this.#waiting.push([a, b, drag.state]);
      }
    }
    return true;
  }
}
