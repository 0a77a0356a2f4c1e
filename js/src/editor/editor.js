/** One view of a model: the word, what edits it, the panel, and what is said about it all. */
import { attr, html, KEEP_KEYS } from "../view/dom.js";
import { Drag, PATIENCE } from "../solver/drag.js";
import { Drawing } from "../view/drawing.js";
import { conform, isArray } from "../word/decode.js";
import { Channel } from "./channel.js";
import { ConstraintBar } from "./constraints.js";
import { Controls } from "./controls.js";
import { DRAG, Gestures, ZOOM } from "./gestures.js";
import { Marks } from "./marks.js";
import { BETTER, BUSY, HINT, KEYS, placeInWords, UNMET, UNSENT } from "./messages.js";
import { copy, css, python, savePng, saveSvg } from "./save.js";
import { Session, TRAITS } from "./session.js";
import { Toolbar } from "./toolbar.js";

/** Milliseconds: stillness before the window moves, and the time that traits get to catch up with the view. */
const CALM = 500, CATCH_UP = 300;

export class Editor {
  /** @param {any} model anywidget's, or that of a page without a kernel */
  constructor(model) {
    this.model = model;
    const view = Math.random().toString(36).slice(2, 12);
    this.ending = new AbortController();
    this.frame = this.calm = this.catchUp = 0;
    this.drawn = -1;
    this.status = { kind: "idle", text: "" };
    /** Where letters press against something in the present drag. @type {[number, number][]} */
    this.touching = [];

    const changed = () => this.request();
    this.session = new Session(model, changed);
    this.drawing = new Drawing();
    this.drawing.onmove = changed;
    this.channel = new Channel({
      view,
      send: (message) => model.send(message),
      onAnswer: (answer, sent) => this.answered(answer, sent),
      onSilence: (sent, error) => this.silence(sent, error),
      onIdle: () => this.idle(),
    });
    this.marks = new Marks(this.drawing.overlay);
    this.gestures = new Gestures({
      drawing: this.drawing, session: this.session, channel: this.channel, changed,
      predicted: (place) => this.say(place.met ? "converged" : "unreachable", placeInWords(place, this.session)),
      guard: (handler) => this.guard(handler),
      signal: this.ending.signal,
    });
    const act = (/** @type {(...values: any[]) => void} */ action) => this.guard((...values) => {
      this.say("idle", "");
      action(...values);
    });
    this.controls = new Controls({
      set: act((changes, source) => {
        this.session.setValues(changes, source);
        this.meet(this.session.constraints, source, Object.keys(changes));
      }),
      begin: (source) => this.session.begin(source),
      lock: act((tag) => this.session.toggleLock(tag)),
      select: act((letter) => this.session.select(letter)),
    }, `vfw-${view}`);
    this.toolbar = new Toolbar({
      undo: act(() => this.step("undo")),
      redo: act(() => this.step("redo")),
      restart: act(() => this.step("restart")),
      resetAll: act(() => this.session.resetAll()),
      unpinAll: act(() => this.session.write({ _pins: [] })),
      share: act((shared) => this.session.setShared(shared)),
      keepApart: act((apart) => this.session.write({ avoid_overlaps: apart })),
      instance: act((index) => this.session.setValues(this.session.word?.instances[index].axes ?? {})),
      save: (what) => this.save(what),
      zoom: act((steps) => {
        this.gestures.zoomStep(ZOOM ** steps);
        changed();
      }),
      fit: act(() => this.drawing.fit()),
    });
    this.bar = new ConstraintBar({
      add: act((kind) => this.constrain(kind)),
      remove: act((index) => this.session.write({ constraints: this.session.constraints.filter((_, i) => i !== index) })),
      change: act((index, value) => this.meet(this.session.constraints.map((c, i) => (i === index ? { ...c, value } : c)))),
    });
    this.toolbar.unpin.after(this.bar.menu);
    this.family = html("div", { class: "vfw-family" });
    this.line = html("div", { class: "vfw-status", role: "status", "aria-live": "polite", tabindex: 0 });
    this.better = html("button", { type: "button", class: "vfw-button vfw-better", hidden: true }, BETTER);
    this.root = html("div", { class: "vfwidget vfwidget-editor" },
      html("div", { class: "vfw-stage" }, this.family, this.drawing.svg, this.toolbar.window),
      html("div", { class: "vfw-bar" }, this.line, this.better, this.toolbar.element), this.bar.element, this.controls.element);
    this.root.addEventListener("keydown", this.guard((event) => this.shortcut(event)), { signal: this.ending.signal });
    for (const [name, value] of Object.entries({ tabindex: 0, role: "application", [KEEP_KEYS]: "true" })) {
      attr(this.drawing.svg, name, value);
    }

    // The picture that a saved notebook shows is hidden while there is a live view.
    const snapshot = String(model.get("_snapshot") ?? "");
    if (/^[0-9a-f]+$/.test(snapshot)) this.root.append(html("style", {}, `.vfw-snapshot-${snapshot} { display: none }`));

    /** @type {[string, (...values: any[]) => void][]} */
    this.listeners = [
      ...TRAITS.map((trait) => /** @type {[string, () => void]} */ ([`change:${trait}`, () => this.session.expire(trait)])),
      ["msg:custom", this.guard((message) => this.receive(message))],
    ];
    for (const [name, listener] of this.listeners) model.on(name, listener);
    this.resizes = new ResizeObserver(() => {
      this.wait();
      changed();
    });
    this.resizes.observe(this.drawing.svg);

    /** What tests reach for. */
    Object.assign(this.root, {
      __vfw: {
        toFont: (/** @type {number} */ x, /** @type {number} */ y) => this.drawing.toFont(x, y),
        toClient: (/** @type {number} */ x, /** @type {number} */ y) => this.drawing.toClient(x, y),
        stats: this.channel.stats,
      },
    });
    this.render();
  }

  /** Work that happens at most once a frame. */
  request() {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      this.render();
    });
  }

  /** A handler that reports what goes wrong and leaves the picture as it is. @param {(...values: any[]) => void} handler */
  guard(handler) {
    return (/** @type {any[]} */ ...values) => {
      try {
        handler.call(this, ...values);
      } catch (error) {
        console.error("vfwidget:", error);
        this.say("error", `Something went wrong in the view: ${/** @type {Error} */ (error)?.message ?? error}`);
      }
    };
  }

  get dragging() {
    return this.gestures.grab !== null || this.channel.busy;
  }

  /** Does the view know better than the traits? */
  get ahead() {
    return this.dragging || this.catchUp !== 0;
  }

  /** @private */
  render() {
    this.guard(this.update)();
    this.guard(this.tell)();
  }

  /** @private */
  update() {
    const { session, drawing, gestures, controls, toolbar } = this;
    const fresh = session.pull(this.ahead), { word } = session;
    this.channel.throttle = session.throttle;
    if (word === null) return;
    if (fresh) {
      gestures.forget();
      drawing.setWord(word, session.axes);
      controls.setWord(word);
      toolbar.setWord(word);
      this.family.textContent = word.family;
      attr(drawing.svg, "aria-label", `${word.string} in ${word.family}. ${HINT} ${KEYS}`);
    }
    if (this.drawn !== session.version) {
      this.drawn = session.version;
      drawing.draw(session.axes);
      attr(drawing.backdrop, "d", session.backdrop);
      const sets = isArray(session.axes) ? session.axes : [session.axes];
      controls.show({ values: session.values, locks: session.locks, shared: session.shared, selected: session.selected });
      this.bar.show(session.constraints, session.pins.length, (letter) => controls.names[letter] ?? "");
      toolbar.show({
        shared: session.shared, apart: session.apart, pins: session.pins.length, steps: session.steps,
        moved: sets.some((values) => word.axes.some((axis) => values[axis.tag] !== axis.default)),
      });
      attr(this.root, "data-theme", session.theme);
      if (session.height === null) this.root.style.removeProperty("--vfw-height");
      else this.root.style.setProperty("--vfw-height", `${session.height}px`);
      this.root.toggleAttribute("data-height", session.height !== null);
      this.wait();
    }
    gestures.refresh();
    this.mark();
    if (!this.channel.busy && session.flush()) this.settle();
  }

  /** @private */
  mark() {
    const { session, drawing, gestures } = this, { layout } = drawing;
    const { handle, mode } = gestures.shown, { grab } = gestures;
    if (layout === null) return;
    const pins = session.pins.flatMap((pin, index) => (layout.has(pin)
      ? [{ at: layout.position(pin), index, hot: gestures.hover?.pin === index }] : []));
    // With other glyphs a pin may have no point until the kernel has moved it to one.
    if (pins.length < session.pins.length && layout.word.rows.length === 1) session.problems.set("_pins", "A pin is not on this word.");
    const i = session.selected;
    this.marks.show({
      pixel: drawing.pixel,
      handle: handle && layout.has(handle) ? layout.position(handle) : null,
      mode,
      tether: grab?.stuck ? grab.target : null,
      pins,
      constraints: session.constraints.map(({ kind, handles, value = 0 }) => (kind === "Width"
        ? [[value, layout.word.descender], [value, layout.word.ascender]]
        : handles.filter((handle) => layout.has(handle)).map((handle) => layout.position(handle)))),
      touching: grab ? this.touching : [],
      underline: session.shared || !(i in layout.x) ? null
        : [layout.x[i], layout.x[i] + layout.advance[i], layout.bottom(i) - 0.07 * layout.word.unitsPerEm],
    });
    attr(drawing.svg, "data-over", grab ? "drag" : gestures.hover ? (gestures.hover.pin >= 0 ? "pin" : "outline") : "");
  }

  /** Puts the most pressing of what there is to say on the status line. @private */
  tell() {
    const { error, problems } = this.session;
    const { kind, text } = error ? { kind: "error", text: error }
      : problems.size > 0 ? { kind: "error", text: [...problems.values()].join("\n") }
        : this.status;
    attr(this.line, "data-status", kind);
    const words = text || HINT;
    if (this.line.textContent !== words) this.line.textContent = this.line.title = words;
  }

  /** @private @param {string} what */
  async save(what) {
    const { session, drawing: { layout } } = this;
    if (layout === null) return;
    try {
      if (what === "Copy CSS") await copy(css(session));
      else if (what === "Copy Python") await copy(python(session));
      else if (what === "Save SVG") saveSvg(layout);
      else await savePng(layout);
      this.say("idle", what.startsWith("Copy") ? "Copied." : "Saved.");
    } catch (error) {
      this.say("error", `This did not work: ${/** @type {Error} */ (error).message}.`);
    }
  }

  /** Makes the pins a constraint. @private @param {import("../solver/terms.js").Constraint["kind"]} kind */
  constrain(kind) {
    const { session, drawing: { layout } } = this;
    if (layout === null) return;
    const handles = kind === "Width" ? [] : session.pins.filter((pin) => layout.has(pin));
    const [[x0, y0], [x1, y1]] = [0, 1].map((i) => (handles[i] ? layout.position(handles[i]) : [0, 0]));
    const value = kind === "Width" ? layout.end : Math.hypot(x1 - x0, y1 - y0);
    session.begin("constraint");
    if (kind !== "Width") session.write({ _pins: [] }, "constraint");
    const constraint = kind === "Width" || kind === "Distance" ? { kind, handles, value } : { kind, handles };
    this.meet([...session.constraints, constraint], "constraint");
  }

  /**
   * Moves the axes so that the constraints are met, by the least change.
   * @private @param {import("../solver/terms.js").Constraint[]} constraints @param {string} [source] @param {string[]} [tags] axes to leave as they are
   */
  meet(constraints, source = "constraint", tags = []) {
    const { session } = this;
    if (session.word === null || (constraints.length === 0 && session.constraints.length === 0)) return;
    const drag = new Drag(session.word, session.axes, { constraints, locks: [...session.locks, ...tags] }), place = drag.to(null, 10 * PATIENCE);
    session.write({ constraints, axes: place.axes }, source);
    if (!place.met) this.say("unreachable", UNMET);
  }

  /** Asks the model for a step of its history. @private @param {"undo" | "redo" | "restart"} type */
  step(type) {
    this.session.flush();
    clearTimeout(this.catchUp);
    this.catchUp = 0;
    try {
      this.model.send({ type });
    } catch {
      this.say("silent", UNSENT);
    }
  }

  /** @private @param {KeyboardEvent} event */
  shortcut(event) {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const key = event.key.toLowerCase(), redo = key === "y" || (key === "z" && event.shiftKey);
    if (!redo && key !== "z") return;
    event.preventDefault();
    event.stopPropagation();
    this.say("idle", "");
    this.step(redo ? "redo" : "undo");
  }

  /** @param {string} kind @param {string} text */
  say(kind, text) {
    this.better.hidden = true;
    if (this.status.kind === kind && this.status.text === text) return;
    this.status = { kind, text };
    this.request();
  }

  /** @private @param {any} message */
  receive(message) {
    // An answer that comes too late still shows that somebody is there.
    if (this.channel.receive(message) === "stale" && this.status.kind === "silent") this.say("idle", "");
  }

  /** @private @param {any} answer @param {import("./channel.js").Message} sent */
  answered(answer, sent) {
    if (!answer.ok) {
      this.session.expire("axes");
      return this.say("error", String(answer.error || "The kernel could not compute this drag."));
    }
    try {
      if (!this.gestures.follow(answer.axes, sent) || !this.session.take(answer.axes)) return;
    } catch (error) {
      this.session.expire("axes");
      return this.say("error", `The kernel sent a malformed answer: ${/** @type {Error} */ (error).message}`);
    }
    if (sent.phase === "up") this.session.finish(sent.gesture);
    this.touching = answer.contacts ?? [];
    this.drawing.layout?.evaluate(this.session.axes);
    this.gestures.judge(sent);
    this.request();
    // The view has said at once what it predicted; where the answer agrees, the words stay.
    if (answer.status && answer.status !== this.status.kind) this.say(String(answer.status), String(answer.message || ""));
    if (answer.elsewhere) this.offer(answer.elsewhere);
  }

  /** Offers a place far away that is better than the one that a drag has reached. @private @param {any} axes */
  offer(axes) {
    this.better.hidden = false;
    this.better.onclick = this.guard(() => {
      this.say("idle", "");
      this.session.write({ axes: conform(/** @type {any} */ (this.session.word), axes, this.session.shared, this.session.selected) });
    });
  }

  /** @private @param {import("./channel.js").Message} sent @param {unknown} error why it could not be sent, if so */
  silence(sent, error) {
    // What the view has computed by itself stays, and goes to the kernel as any other change.
    if (sent.phase === "up") this.session.write({ axes: this.session.axes }, DRAG);
    this.say("silent", error ? UNSENT : BUSY);
  }

  /** Nothing is asked any more: what waited can be written. @private */
  idle() {
    this.settle();
    this.request();
  }

  /**
   * Gives the traits the last word, once they had time to catch up: until then they may still say
   * what was true a few messages ago. @private
   */
  settle() {
    clearTimeout(this.catchUp);
    this.catchUp = setTimeout(() => {
      this.catchUp = 0;
      this.session.expire("axes");
    }, CATCH_UP);
  }

  /** Fits the window once nothing has moved for a while. @private */
  wait() {
    clearTimeout(this.calm);
    this.calm = setTimeout(() => {
      if (this.dragging || this.controls.pressed) this.wait();
      else if (!this.drawing.fits) this.drawing.fit();
    }, CALM);
  }

  destroy() {
    this.guard(() => {
      this.gestures.finishKeys();
      this.gestures.lose({ pointerId: this.gestures.grab?.id });
      this.channel.close();
      this.session.flush();
    })();
    for (const [name, listener] of this.listeners) this.model.off(name, listener);
    this.ending.abort();
    this.resizes.disconnect();
    this.drawing.hold();
    cancelAnimationFrame(this.frame);
    clearTimeout(this.calm);
    clearTimeout(this.catchUp);
    this.frame = 0;
    this.root.remove();
  }
}
