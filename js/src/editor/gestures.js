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

export class Gestures {
  /**
   * @param {object} parts
   * @param {import("../view/drawing.js").Drawing} parts.drawing
   * @param {import("./session.js").Session} parts.session
   * @param {import("./channel.js").Channel} parts.channel
   * @param {(place: import("../solver/drag.js").Place) => void} parts.predicted hears of each prediction that is shown
   * @param {() => void} parts.changed asks for a frame
   * @param {(handler: (event: any) => void) => (event: any) => void} parts.guard
   * @param {AbortSignal} parts.signal removes the listeners
   */
  constructor({ drawing, session, channel, predicted, changed, guard, signal }) {
    this.drawing = drawing;
    this.session = session;
    this.channel = channel;
    this.predicted = predicted;
    this.changed = changed;
    /** @type {{handle: Handle, pin: number} | null} */
    this.hover = null;
    /** @type {Grab | null} */
    this.grab = null;
    /** What the keys move. @type {Handle | null} */
    this.last = null;
    /** Where the pointer rests on the picture. @type {[number, number] | null} */
    this.pointer = null;
    /** Where the pointer of a drag was last. @type {[number, number] | null} */
    this.previous = null;
    /** Pointers that move the picture: one pans, two zoom as well. @type {Map<number, [number, number]>} */
    this.holds = new Map();
    const on = (/** @type {string} */ type, /** @type {(e: any) => void} */ handler) =>
      drawing.svg.addEventListener(type, guard((event) => {
        handler.call(this, event);
        changed();
      }), { signal, passive: false });
    on("pointerdown", this.press);
    on("pointermove", this.move);
    on("pointerup", this.release);
    on("pointercancel", this.lose);
    on("lostpointercapture", this.lose);
    on("pointerleave", () => (this.pointer = null));
    on("dblclick", (event) => this.pick(event.clientX, event.clientY) || drawing.fit());
    // A touch scrolls the page unless it meets the outline or comes with a second finger.
    on("touchstart", (event) => {
      const { clientX, clientY } = event.touches[0];
      if (event.touches.length > 1 || this.pick(clientX, clientY, TOUCH)) event.preventDefault();
    });
    // So does the wheel, unless it zooms; a pinch on a touch pad arrives as a wheel with Ctrl.
    on("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      this.zoom(Math.exp(-0.01 * Math.max(-40, Math.min(40, event.deltaY))), event.clientX, event.clientY);
    });
    on("keydown", this.key);
    on("keyup", (event) => event.key in ARROWS && this.finishKeys());
    on("blur", this.finishKeys);
    on("focus", () => {}); // the keys' handle appears
  }

  /** The outline point or pin at a place on the page. @param {number} x @param {number} y @param {number} reach */
  pick(x, y, reach = REACH) {
    const { layout, pixel } = this.drawing;
    const { x: fx, y: fy } = this.drawing.toFont(x, y);
    if (layout === null || !Number.isFinite(fx)) return null;
    let pin = -1, distance = PIN_REACH * pixel;
    this.session.pins.forEach((handle, i) => {
      if (!layout.has(handle)) return;
      const [px, py] = layout.position(handle), d = Math.hypot(px - fx, py - fy);
      if (d < distance) [pin, distance] = [i, d];
    });
    if (pin >= 0) return { handle: this.session.pins[pin], pin };
    const near = nearest(layout, fx, fy, reach * pixel);
    if (near === null) return null;
    return { handle: /** @type {Handle} */ ([near.glyph, near.contour, near.segment, near.t]), pin };
  }

  /** Brings the hover in step with the pointer and the picture. */
  refresh() {
    this.hover = this.pointer && this.grab === null ? this.pick(...this.pointer) : null;
    if (this.last && !this.drawing.layout?.has(this.last)) this.last = null;
  }

  /** The point shown as a dot, and why. @returns {{handle: Handle | null, mode: string}} */
  get shown() {
    if (this.grab) return { handle: this.grab.handle, mode: "drag" };
    if (this.hover) return { handle: this.hover.handle, mode: "hover" };
    return { handle: this.drawing.svg.matches(":focus-visible") ? this.last : null, mode: "keys" };
  }

  /** @param {number} factor @param {number} x @param {number} y on the page */
  zoom(factor, x, y) {
    const place = this.drawing.toFont(x, y);
    this.drawing.chosen = true;
    this.drawing.zoom(factor, [place.x, place.y]);
  }

  /** @param {PointerEvent} event */
  press(event) {
    const { layout } = this.drawing, touch = event.pointerType === "touch";
    if (layout === null) return;
    /** @type {[number, number]} */
    const at = [event.clientX, event.clientY];
    if (!event.isPrimary || event.button === 1) {
      // A second finger, or the middle button: the picture is moved, and a drag ends where it is.
      if (this.grab) this.holds.set(this.grab.id, this.grab.last);
      this.lose({ pointerId: this.grab?.id });
      return this.hold(event, at);
    }
    if (event.button !== 0) return;
    this.finishKeys();
    this.lose({ pointerId: this.grab?.id });
    this.drawing.hold();
    const found = this.pick(at[0], at[1], touch ? TOUCH : REACH);
    const { x, y } = this.drawing.toFont(at[0], at[1]);
    const letter = found ? found.handle[0]
      : layout.row.order.findIndex((_, i) => x >= layout.x[i] && x < layout.x[i] + layout.advance[i]);
    if (letter >= 0) this.session.select(letter);
    if (found === null) {
      this.holds.clear();
      if (touch) this.holds.set(event.pointerId, at); // the page may scroll
      else this.hold(event, at);
      return;
    }
    const origin = layout.position(found.handle);
    this.grab = {
      handle: found.handle, by: "pointer", id: event.pointerId, start: at, last: at,
      offset: [origin[0] - x, origin[1] - y], origin, target: origin, before: this.session.axes,
      drag: null, follows: false, stuck: false,
    };
    this.last = found.handle;
    this.drawing.svg.setPointerCapture(event.pointerId);
  }

  /** @private @param {PointerEvent} event @param {[number, number]} at */
  hold(event, at) {
    event.preventDefault();
    this.holds.set(event.pointerId, at);
    this.drawing.svg.setPointerCapture(event.pointerId);
  }

  /** A pointer that holds the picture has moved: pan, and zoom by the distance of two. @private @param {number} id @param {[number, number]} to */
  slide(id, to) {
    const from = this.holds.get(id);
    if (!from) return;
    const other = [...this.holds].find(([key]) => key !== id)?.[1];
    const apart = (/** @type {[number, number]} */ a) => (other ? Math.hypot(a[0] - other[0], a[1] - other[1]) : 0);
    this.holds.set(id, to);
    this.drawing.chosen = true;
    this.drawing.pan((to[0] - from[0]) / this.holds.size, (to[1] - from[1]) / this.holds.size);
    if (other && apart(from) > 0) this.zoom(apart(to) / apart(from), (to[0] + other[0]) / 2, (to[1] + other[1]) / 2);
  }

  /** @param {PointerEvent} event */
  move(event) {
    const { grab } = this;
    /** @type {[number, number]} */
    const at = [event.clientX, event.clientY];
    if (event.pointerType !== "touch" || grab) this.pointer = at;
    if (this.holds.has(event.pointerId)) {
      if (event.pointerType !== "touch" || this.holds.size > 1) this.slide(event.pointerId, at);
      return;
    }
    if (grab?.by !== "pointer" || grab.id !== event.pointerId) return;
    if (!grab.drag && Math.hypot(at[0] - grab.start[0], at[1] - grab.start[1]) < CLICK) return;
    const pace = event.shiftKey ? SLOW : 1;
    const [x0, y0] = this.previous ?? grab.start;
    grab.last = [grab.last[0] + pace * (at[0] - x0), grab.last[1] + pace * (at[1] - y0)];
    this.previous = at;
    const { x, y } = this.drawing.toFont(...grab.last);
    if (!Number.isFinite(x)) return;
    this.open(grab);
    grab.target = [x + grab.offset[0], y + grab.offset[1]];
    this.say(grab, "move", grab.target);
    this.drawing.layout?.evaluate(this.session.axes);
    this.drawing.follow([x, y]);
  }

  /** @param {PointerEvent} event */
  release(event) {
    const { grab } = this;
    this.holds.delete(event.pointerId);
    if (grab?.by !== "pointer" || grab.id !== event.pointerId) return;
    this.move(event);
    this.end(grab);
    if (event.pointerType === "touch") this.pointer = null;
    if (!grab.drag) this.togglePin(grab.handle);
  }

  /** @private @param {Grab} grab */
  end(grab) {
    this.grab = null;
    this.previous = null;
    if (grab.drag) this.say(grab, "up", grab.target);
  }

  /** The browser took the pointer away: the drag ends where it got to. @param {{pointerId?: number}} event */
  lose(event) {
    const { grab } = this;
    this.holds.delete(event.pointerId ?? -1);
    if (grab?.by === "pointer" && grab.id === event.pointerId) this.end(grab);
  }

  /** Back to before the drag: the kernel hears of its end, and then of the axes from before. */
  cancel() {
    const { grab } = this;
    if (grab === null) return false;
    this.grab = this.previous = null;
    if (!grab.drag) return true;
    this.session.predict(grab.before);
    this.push(grab, "up", grab.origin);
    this.session.write({ axes: grab.before }, DRAG);
    return true;
  }

  /** The word is another one: the drag has no meaning any more, so nothing of it is sent. */
  forget() {
    this.grab = this.hover = this.last = this.previous = null;
    this.channel.reset();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const { layout } = this.drawing;
    if (layout === null || event.altKey || event.ctrlKey || event.metaKey) return;
    const arrow = ARROWS[event.key];
    if (arrow) this.nudge(arrow[0] * (event.shiftKey ? 10 : 1), arrow[1] * (event.shiftKey ? 10 : 1));
    else if (event.key === "+" || event.key === "=" || event.key === "-") this.zoomStep(event.key === "-" ? 1 / ZOOM : ZOOM);
    else if (event.key === "0") this.drawing.fit();
    else if (event.key === "PageDown" || event.key === "PageUp") this.step(event.key === "PageDown" ? 1 : -1);
    else if ((event.key === "Enter" || event.key === " ") && this.last && !this.grab) this.togglePin(this.last);
    else if (event.key !== "Escape" || !this.cancel()) return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Zooms about the middle of the picture. @param {number} factor */
  zoomStep(factor) {
    const { left, top, width, height } = this.drawing.svg.getBoundingClientRect();
    this.zoom(factor, left + width / 2, top + height / 2);
  }

  /** @param {number} dx pixels @param {number} dy pixels, up */
  nudge(dx, dy) {
    const { layout } = this.drawing;
    if (this.grab?.by === "pointer" || layout === null) return;
    if (this.last === null) this.step(1);
    if (this.last === null) return;
    if (this.grab === null) {
      const origin = layout.position(this.last);
      this.grab = {
        handle: this.last, by: "keys", id: -1, start: [0, 0], last: [0, 0], offset: [0, 0], origin, target: origin,
        before: this.session.axes, drag: null, follows: false, stuck: false,
      };
    }
    const { grab } = this, { pixel } = this.drawing;
    this.open(grab);
    grab.target = [grab.target[0] + dx * pixel, grab.target[1] + dy * pixel];
    this.say(grab, "move", grab.target);
  }

  finishKeys() {
    if (this.grab?.by === "keys") this.end(this.grab);
  }

  /** The keys' handle goes to the next or the previous start of a segment. @param {number} by */
  step(by) {
    const { layout } = this.drawing;
    if (this.grab || layout === null) return;
    /** @type {Handle[]} */
    const starts = layout.glyphs.flatMap(({ contours }, letter) => contours.flatMap((segments, contour) =>
      Array.from({ length: segments }, (_, segment) => /** @type {Handle} */ ([letter, contour, segment, 0]))));
    if (starts.length === 0) return;
    const [letter, contour, segment] = this.last ?? [];
    const now = starts.findIndex((h) => h[0] === letter && h[1] === contour && h[2] === segment);
    this.last = now < 0 ? starts[0] : starts[(now + by + starts.length) % starts.length];
    this.session.select(this.last[0]);
  }

  /** @param {Handle} handle */
  togglePin(handle) {
    const pins = this.session.pins.filter((pin) => this.drawing.layout?.has(pin));
    const others = pins.filter((pin) => !same(handle, pin));
    this.session.write({ _pins: others.length < pins.length ? others : [...pins, handle] });
  }

  /** @private @param {Grab} grab */
  open(grab) {
    if (grab.drag) return;
    const { session, drawing } = this, { layout } = drawing;
    if (layout === null) return;
    grab.before = session.axes;
    if (grab.by === "keys") session.resume(KEYS);
    else session.begin(DRAG);
    const pins = session.pins.filter((pin) => layout.has(pin) && !same(pin, grab.handle));
    grab.drag = new Drag(layout.word, grab.before, { ...session.wishes, handle: grab.handle, pins });
    // What overlaps, only the kernel knows.
    grab.follows = !!session.apart;
    this.say(grab, "down", grab.origin);
  }

  /** Shows where a drag leads, and tells the kernel. @private @param {Grab} grab @param {"down" | "move" | "up"} phase @param {[number, number]} at */
  say(grab, phase, at) {
    if (!grab.drag) return;
    const { session } = this;
    if (phase !== "down" && !grab.follows) {
      const place = grab.drag.to(at, phase === "move" ? PATIENCE : Infinity);
      session.predict(place.axes);
      grab.stuck = place.missing > CLICK * this.drawing.pixel;
      this.predicted(place);
    }
    this.push(grab, phase, at);
  }

  /** @private @param {Grab} grab @param {"down" | "move" | "up"} phase @param {[number, number]} at */
  push(grab, phase, [x, y]) {
    const { axes, gesture } = this.session;
    this.channel.push({ phase, handle: [...grab.handle], x, y, axes, gesture: gesture.name });
  }

  /**
   * Where the kernel's answer differs from what was predicted for the same place, it knows more: for the rest of this
   * drag the view follows its answers.
   * @param {any} axes the answer @param {import("./channel.js").Message} sent
   * @returns {boolean} whether the answer is to be shown
   */
  follow(axes, sent) {
    const { grab, drawing } = this;
    if (!grab) return !this.channel.busy;
    grab.follows ||= drawing.distance(axes, sent.axes) > drawing.pixel;
    return grab.follows;
  }

  /** After an answer that is shown: does the outline lag for a better reason than the time it took? @param {{x: number, y: number}} asked */
  judge({ x, y }) {
    const { grab } = this, { layout, pixel } = this.drawing;
    if (!grab?.follows || layout === null) return;
    const [px, py] = layout.position(grab.handle);
    grab.stuck = Math.hypot(px - x, py - y) > CLICK * pixel;
  }
}
