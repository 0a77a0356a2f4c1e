/** What editing draws over a word: the handle, the line to a target out of reach, pins, the selection. */
import { attr, svg } from "../view/dom.js";

/** Sizes in pixels: marks keep theirs whatever the zoom. */
const HANDLE = 5.5, PIN = 6.5;

/** @param {SVGGElement} group */
export function createMarks(group) {
  const mark = {
    reach: svg("path", { class: "vfw-reachable" }),
    constraints: svg("path", { class: "vfw-constraint-lines" }),
    touching: svg("path", { class: "vfw-contacts" }),
    underline: svg("path", { class: "vfw-selected" }),
    tether: svg("line", { class: "vfw-tether" }),
    target: svg("circle", { class: "vfw-target" }),
    pins: svg("g", { class: "vfw-pins" }),
    handle: svg("circle", { class: "vfw-handle" }),
  };
  group.append(...Object.values(mark));

  /**
   * @param {object} state places in word coordinates, y up
   * @param {number} state.pixel font units a pixel takes
   * @param {[number, number] | null} state.handle
   * @param {string} state.mode "hover" | "drag" | "keys"
   * @param {[number, number] | null} state.tether the target that the handle cannot follow to
   * @param {{at: [number, number], index: number, hot: boolean}[]} state.pins
   * @param {[number, number][][]} state.constraints the points of each
   * @param {[number, number][]} state.touching where letters press against something
   * @param {import("./reach.js").Reach | null} state.reach
   * @param {[number, number, number][]} state.underline left, right and y on each line of text
   */
  function show({ pixel, handle, mode, tether, pins, constraints, touching, reach, underline }) {
    // A line without length is drawn as a round dot.
    attr(mark.reach, "d", reach?.path ?? "");
    attr(mark.reach, "stroke-width", reach?.width ?? 0);
    attr(mark.touching, "d", touching.map(([x, y]) => `M${x} ${-y}h0`).join(""));
    attr(mark.constraints, "d", constraints.map((points) =>
      points.map(([x, y], i) => `${i ? "L" : "M"}${x} ${-y}`).join("")).join(""));
    const on = tether !== null && handle !== null;
    place(mark.handle, handle, { r: HANDLE * pixel });
    attr(mark.handle, "data-mode", mode);
    place(mark.target, on ? tether : null, { r: 2.5 * pixel });
    line(mark.tether, on ? [handle[0], handle[1], tether[0], tether[1]] : null);
    attr(mark.underline, "d", underline.map(([left, right, y]) => `M${left} ${-y}H${right}`).join(""));
    const drawn = mark.pins.children;
    while (drawn.length > pins.length) drawn[0].remove();
    while (drawn.length < pins.length) mark.pins.append(pin());
    pins.forEach(({ at, index, hot }, i) => {
      attr(drawn[i], "transform", `translate(${at[0]} ${-at[1]}) scale(${pixel})`);
      attr(drawn[i], "data-pin", index);
      drawn[i].toggleAttribute("data-hot", hot);
    });
  }

  return { show };
}

/** A square on its corner with a hole: told from the round handle without colour. */
function pin() {
  const d = `M0 ${-PIN}L${PIN} 0L0 ${PIN}L${-PIN} 0Z`;
  return svg("g", { class: "vfw-pin" }, svg("path", { d }), svg("circle", { r: 1.75 }));
}

/** @param {SVGElement} circle @param {[number, number] | null} at @param {Record<string, number>} more */
function place(circle, at, more) {
  toggle(circle, at !== null);
  if (at === null) return;
  for (const [name, value] of Object.entries({ cx: at[0], cy: -at[1], ...more })) attr(circle, name, value);
}

/** @param {SVGElement} element @param {number[] | null} ends x1, y1, x2, y2, y up */
function line(element, ends) {
  toggle(element, ends !== null);
  if (ends === null) return;
  ["x1", "y1", "x2", "y2"].forEach((name, i) => attr(element, name, i % 2 ? -ends[i] : ends[i]));
}

/** @param {SVGElement} element @param {boolean} on */
function toggle(element, on) {
  if (on) element.removeAttribute("display");
  else attr(element, "display", "none");
}
