/**
 * Pointer and keyboard on the outline: hover, drag, click to pin, arrow keys. A drag is solved here at once and
 * sent to the kernel, whose answer has the last word.
 */
import { Drag, PATIENCE } from "../solver/drag.js";
import { nearest } from "../word/cubics.js";

/**
 * @typedef {import("../word/forward.js").Handle} Handle
 * @typedef {{handle: Handle, by: "pointer" | "keys", id: number, start: [number, number], last: [number, number],
 *   offset: [number, number], origin: [number, number], target: [number, number], before: any,
 *   drag: Drag | null, follows: boolean, stuck: boolean}} Grab
 *   `last`: the place on the page that the point follows, which slow dragging sets apart from the pointer; `drag`: null up to the click threshold; `follows`: the kernel solves for more than the view knows, so the view
 *   shows the kernel's answers and no predictions
 */

/** Pixels: how far the outline attracts, how far a pin does, and how far a click may wander. */
const REACH = 24, TOUCH = 36, PIN_REACH = 10, CLICK = 3;
/** While Shift is held, the outline moves by this share of the way. */
const SLOW = 0.2;
/** The sources of changes, in the history. */
export const DRAG = "drag";
const KEYS = "keys";
/** One step of the zoom, by key or button. */
export const ZOOM = 1.25;

/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

const same = (/** @type {Handle} */ a, /** @type {Handle} */ b) => a.every((v, i) => Math.abs(v - b[i]) < 1e-9);

/**
 * @param {object} parts
 * @param {import("../view/drawing.js").Drawing} parts.drawing
 * @param {import("./session.js").Session} parts.session
 * @param {import("./channel.js").Channel} parts.channel
 * @param {(place: import("../solver/drag.js").Place) => void} parts.predicted hears of each prediction that is shown
 * @param {(handler: (event: any) => void) => (event: any) => void} parts.atOnce a handler whose result is drawn when it returns
 * @param {AbortSignal} parts.signal removes the listeners
 */
export function createGestures({ drawing, session, channel, predicted, atOnce, signal }) {
  /** @type {{handle: Handle, pin: number} | null} */
  let hover = null;
  /** @type {Grab | null} */
  let grab = null;
  /** What the keys move. @type {Handle | null} */
  let last = null;
  /** Where the pointer rests on the picture. @type {[number, number] | null} */
  let pointer = null;
  /** Whether the last event of a drag was predicted, and not left to the kernel. */
  let foretold = false;
  /** Where the pointer of a drag was last. @type {[number, number] | null} */
  let previous = null;
  /** Pointers that move the picture: one pans, two zoom as well. @type {Map<number, [number, number]>} */
  const holds = new Map();
  /** Predicted axes of which the solver had too little time; the kernel's answer may differ from them. @type {WeakSet<object>} */
  const unfinished = new WeakSet();
  const on = (/** @type {string} */ type, /** @type {(e: any) => void} */ handler) =>
    drawing.svg.addEventListener(type, atOnce(handler), { signal, passive: false });
  on("pointerdown", press);
  on("pointermove", move);
  on("pointerup", release);
  on("pointercancel", lose);
  on("lostpointercapture", lose);
  on("pointerleave", () => (pointer = null));
  on("dblclick", (event) => pick(event.clientX, event.clientY) || drawing.fit());
  // A touch scrolls the page unless it meets the outline or comes with a second finger.
  on("touchstart", (event) => {
    const { clientX, clientY } = event.touches[0];
    if (event.touches.length > 1 || pick(clientX, clientY, TOUCH)) event.preventDefault();
  });
  // So does the wheel, unless it zooms; a pinch on a touch pad arrives as a wheel with Ctrl.
  on("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoom(Math.exp(-0.01 * Math.max(-40, Math.min(40, event.deltaY))), event.clientX, event.clientY);
  });
  on("keydown", pressKey);
  on("keyup", (event) => event.key in ARROWS && finishKeys());
  on("blur", finishKeys);
  on("focus", () => {}); // the keys' handle appears

  /** The outline point or pin at a place on the page. @param {number} x @param {number} y @param {number} reach */
  function pick(x, y, reach = REACH) {
    const { layout, pixel } = drawing;
    const { x: fx, y: fy } = drawing.toFont(x, y);
    if (layout === null || !Number.isFinite(fx)) return null;
    let pin = -1, distance = PIN_REACH * pixel;
    session.pins.forEach((handle, i) => {
      if (!layout.has(handle)) return;
      const [px, py] = layout.position(handle), d = Math.hypot(px - fx, py - fy);
      if (d < distance) [pin, distance] = [i, d];
    });
    if (pin >= 0) return { handle: session.pins[pin], pin };
    const near = nearest(layout, fx, fy, reach * pixel);
    if (near === null) return null;
    return { handle: /** @type {Handle} */ ([near.glyph, near.contour, near.segment, near.t]), pin };
  }

  /** Brings the hover in step with the pointer and the picture. */
  function refresh() {
    hover = pointer && grab === null ? pick(...pointer) : null;
    if (last && !drawing.layout?.has(last)) last = null;
  }

  /** The point shown as a dot, and why. @returns {{handle: Handle | null, mode: string}} */
  function shown() {
    if (grab) return { handle: grab.handle, mode: "drag" };
    if (hover) return { handle: hover.handle, mode: "hover" };
    return { handle: drawing.svg.matches(":focus-visible") ? last : null, mode: "keys" };
  }

  /** @param {number} factor @param {number} x @param {number} y on the page */
  function zoom(factor, x, y) {
    const place = drawing.toFont(x, y);
    drawing.chosen = true;
    drawing.zoom(factor, [place.x, place.y]);
  }

  /** @param {PointerEvent} event */
  function press(event) {
    const { layout } = drawing, { pointerId: id, button } = event, touch = event.pointerType === "touch";
    if (layout === null) return;
    /** @type {[number, number]} */
    const at = [event.clientX, event.clientY];
    if (!event.isPrimary || button === 1) {
      // A second finger, or the middle button: the picture is moved, and a drag ends where it is.
      if (grab) holds.set(grab.id, grab.last);
      drop();
      return hold(event, at);
    }
    if (button !== 0) return;
    finishKeys();
    drop();
    drawing.hold();
    const found = pick(at[0], at[1], touch ? TOUCH : REACH);
    const { x, y } = drawing.toFont(at[0], at[1]);
    const letter = found ? found.handle[0] : layout.letterAt(x, y);
    if (letter >= 0) session.select(letter, event.ctrlKey || event.metaKey ? "to" : "within");
    if (found === null) {
      holds.clear();
      if (touch) holds.set(id, at); // the page may scroll
      else hold(event, at);
      return;
    }
    take((last = found.handle), layout.position(last), "pointer", id, at, [x, y]);
    drawing.svg.setPointerCapture(id);
  }

  /**
   * @param {Handle} handle @param {[number, number]} origin @param {"pointer" | "keys"} by @param {number} id
   * @param {[number, number]} start @param {[number, number]} pressed in font units
   */
  function take(handle, origin, by, id, start, [x, y]) {
    grab = {
      handle, by, id, start, last: start, offset: [origin[0] - x, origin[1] - y], origin, target: origin,
      before: session.axes, drag: null, follows: false, stuck: false,
    };
  }

  /** @param {PointerEvent} event @param {[number, number]} at */
  function hold(event, at) {
    event.preventDefault();
    holds.set(event.pointerId, at);
    drawing.svg.setPointerCapture(event.pointerId);
  }

  /** A pointer that holds the picture has moved: pan, and zoom by the distance of two. @param {number} id @param {[number, number]} to */
  function slide(id, to) {
    const from = holds.get(id);
    if (!from) return;
    const other = [...holds].find(([key]) => key !== id)?.[1];
    const apart = (/** @type {[number, number]} */ a) => (other ? Math.hypot(a[0] - other[0], a[1] - other[1]) : 0);
    holds.set(id, to);
    drawing.chosen = true;
    drawing.pan((to[0] - from[0]) / holds.size, (to[1] - from[1]) / holds.size);
    if (other && apart(from) > 0) zoom(apart(to) / apart(from), (to[0] + other[0]) / 2, (to[1] + other[1]) / 2);
  }

  /** @param {PointerEvent} event */
  function move(event) {
    const { pointerId: id } = event, touch = event.pointerType === "touch";
    /** @type {[number, number]} */
    const at = [event.clientX, event.clientY];
    if (!touch || grab) pointer = at;
    if (holds.has(id)) {
      if (!touch || holds.size > 1) slide(id, at);
      return;
    }
    if (grab?.by !== "pointer" || grab.id !== id) return;
    const place = track(grab, event, at);
    if (!place) return;
    say(grab, "move", grab.target);
    drawing.layout?.evaluate(session.axes);
    drawing.follow(place);
  }

  /**
   * Moves the target of a drag with the pointer, and begins the drag once the pointer has left the place of a click.
   * @param {Grab} grab @param {PointerEvent} event @param {[number, number]} at @returns {[number, number] | null} the pointer in font units
   */
  function track(grab, event, at) {
    if (!grab.drag && Math.hypot(at[0] - grab.start[0], at[1] - grab.start[1]) < CLICK) return null;
    const pace = event.shiftKey ? SLOW : 1;
    const [x0, y0] = previous ?? grab.start;
    grab.last = [grab.last[0] + pace * (at[0] - x0), grab.last[1] + pace * (at[1] - y0)];
    previous = at;
    const { x, y } = drawing.toFont(...grab.last);
    if (!Number.isFinite(x)) return null;
    open(grab);
    grab.target = [x + grab.offset[0], y + grab.offset[1]];
    return [x, y];
  }

  /** @param {PointerEvent} event */
  function release(event) {
    const held = grab;
    holds.delete(event.pointerId);
    if (held?.by !== "pointer" || held.id !== event.pointerId) return;
    pointer = [event.clientX, event.clientY];
    track(held, event, pointer);
    end(held);
    if (event.pointerType === "touch") pointer = null;
    if (!held.drag) togglePin(held.handle);
  }

  /** @param {Grab} ended */
  function end(ended) {
    grab = previous = null;
    if (ended.drag) say(ended, "up", ended.target);
  }

  /** The browser took the pointer away: the drag ends where it got to. @param {{pointerId?: number}} event */
  function lose(event) {
    holds.delete(event.pointerId ?? -1);
    if (grab?.by === "pointer" && grab.id === event.pointerId) end(grab);
  }

  /** Ends a drag by a pointer where it got to. */
  function drop() {
    lose({ pointerId: grab?.id });
  }

  /** Back to before the drag: the kernel hears of its end, and then of the axes from before. */
  function cancel() {
    const taken = grab;
    if (taken === null) return false;
    grab = previous = null;
    if (!taken.drag) return true;
    session.predict(taken.before);
    push(taken, "up", taken.origin);
    session.write({ axes: taken.before }, DRAG);
    return true;
  }

  /** The word is another one: the drag has no meaning any more, so nothing of it is sent. */
  function forget() {
    grab = hover = last = previous = null;
    channel.reset();
  }

  /** @param {KeyboardEvent} event */
  function pressKey(event) {
    const { layout } = drawing, { key } = event;
    if (layout === null || event.altKey || event.ctrlKey || event.metaKey) return;
    const arrow = ARROWS[key], pace = event.shiftKey ? 10 : 1;
    if (arrow) nudge(arrow[0] * pace, arrow[1] * pace);
    else if (key === "+" || key === "=" || key === "-") zoomStep(key === "-" ? 1 / ZOOM : ZOOM);
    else if (key === "0") drawing.fit();
    else if (key === "PageDown" || key === "PageUp") step(key === "PageDown" ? 1 : -1);
    else if ((key === "Enter" || key === " ") && last && !grab) togglePin(last);
    else if (key !== "Escape" || !cancel()) return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Zooms about the middle of the picture. @param {number} factor */
  function zoomStep(factor) {
    const { left, top, width, height } = drawing.svg.getBoundingClientRect();
    zoom(factor, left + width / 2, top + height / 2);
  }

  /** @param {number} dx pixels @param {number} dy pixels, up */
  function nudge(dx, dy) {
    const { layout } = drawing;
    if (grab?.by === "pointer" || layout === null) return;
    if (last === null) step(1);
    if (last === null) return;
    if (grab === null) {
      session.select(last[0], "within");
      take(last, layout.position(last), "keys", -1, [0, 0], [0, 0]);
    }
    const { pixel } = drawing, held = /** @type {Grab} */ (/** @type {unknown} */ (grab));
    open(held);
    held.target = [held.target[0] + dx * pixel, held.target[1] + dy * pixel];
    say(held, "move", held.target);
  }

  function finishKeys() {
    if (grab?.by === "keys") end(grab);
  }

  /** The keys' handle goes to the next or the previous start of a segment. @param {number} by */
  function step(by) {
    const { layout } = drawing;
    if (grab || layout === null) return;
    /** @type {Handle[]} */
    const starts = layout.glyphs.flatMap(({ contours }, letter) => contours.flatMap((segments, contour) =>
      Array.from({ length: segments }, (_, segment) => /** @type {Handle} */ ([letter, contour, segment, 0]))));
    if (starts.length === 0) return;
    const [letter, contour, segment] = last ?? [];
    const now = starts.findIndex((h) => h[0] === letter && h[1] === contour && h[2] === segment);
    last = now < 0 ? starts[0] : starts[(now + by + starts.length) % starts.length];
    session.select(last[0], "within");
  }

  /** @param {Handle} handle */
  function togglePin(handle) {
    const pins = session.pins.filter((pin) => drawing.layout?.has(pin));
    const others = pins.filter((pin) => !same(handle, pin));
    session.write({ _pins: others.length < pins.length ? others : [...pins, handle] });
  }

  /** @param {Grab} grab */
  function open(grab) {
    if (grab.drag) return;
    const { layout } = drawing;
    if (layout === null) return;
    grab.before = session.axes;
    if (grab.by === "keys") session.resume(KEYS);
    else session.begin(DRAG);
    session.predict(session.together);
    grab.drag = dragOf(grab.handle);
    // What overlaps, only the kernel knows.
    grab.follows = !!session.apart;
    say(grab, "down", grab.origin);
  }

  /** A drag of a point from where the word is. @param {Handle} handle */
  function dragOf(handle) {
    const { layout } = drawing;
    const pins = session.pins.filter((pin) => layout?.has(pin) && !same(pin, handle));
    return new Drag(/** @type {any} */ (session.word), session.together, { ...session.wishes, handle, pins });
  }

  /** Shows where a drag leads, and tells the kernel. @param {Grab} grab @param {"down" | "move" | "up"} phase @param {[number, number]} at */
  function say(grab, phase, at) {
    if (!grab.drag) return;
    foretold = phase !== "down" && !grab.follows;
    if (foretold) {
      const place = grab.drag.to(at, phase === "move" ? PATIENCE : Infinity);
      session.predict(place.axes);
      if (!place.finished) unfinished.add(place.axes);
      grab.stuck = place.missing > CLICK * drawing.pixel;
      predicted(place);
    }
    push(grab, phase, at);
  }

  /** @param {Grab} grab @param {"down" | "move" | "up"} phase @param {[number, number]} at */
  function push(grab, phase, [x, y]) {
    const { axes, gesture, range } = session;
    channel.push({ phase, handle: [...grab.handle], x, y, axes, range, gesture: gesture.name });
  }

  /**
   * Where the kernel's answer differs from what was predicted for the same place, it knows more: for the rest of this
   * drag the view follows its answers.
   * @param {any} axes the answer @param {import("./channel.js").Message} sent
   * @returns {boolean} whether the answer is to be shown
   */
  function follow(axes, sent) {
    if (!grab) return !channel.busy;
    grab.follows ||= !unfinished.has(sent.axes) && drawing.distance(axes, sent.axes) > drawing.pixel;
    return grab.follows;
  }

  /** After an answer that is shown: does the outline lag for a better reason than the time it took? @param {{x: number, y: number}} asked */
  function judge({ x, y }) {
    const { layout, pixel } = drawing;
    if (!grab?.follows || layout === null) return;
    const [px, py] = layout.position(grab.handle);
    grab.stuck = Math.hypot(px - x, py - y) > CLICK * pixel;
  }

  return {
    get grab() { return grab; },
    get foretold() { return foretold; },
    get hover() { return hover; },
    get shown() { return shown(); },
    /** The point that is held, or was moved last. */
    get held() { return grab?.handle ?? last; },
    refresh, forget, drop, finishKeys, zoomStep, dragOf, follow, judge,
  };
}
