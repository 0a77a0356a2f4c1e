/** One view of a model: the word, what edits it, the panel, and what is said about it all. */
import { attr, html, KEEP_KEYS } from "../view/dom.js";
import { Drag, PATIENCE } from "../solver/drag.js";
import { Drawing } from "../view/drawing.js";
import { isArray } from "../word/decode.js";
import { Channel } from "./channel.js";
import { createConstraintBar } from "./constraints.js";
import { createControls } from "./controls.js";
import { createGestures, DRAG, ZOOM } from "./gestures.js";
import { createMarks } from "./marks.js";
import { BUSY, HINT, KEYS, LATER, placeInWords, REACH, UNMET, UNSENT } from "./messages.js";
import { Session, TRAITS } from "./session.js";
import { createStatus } from "./status.js";
import { createToolbar } from "./toolbar.js";

/** Milliseconds: stillness before the window moves, and the time that traits get to catch up with the view. */
const CALM = 500, CATCH_UP = 300;
/** The places that a point can reach: milliseconds in each frame to find them, and pixels between them. */
const SHARE = 6, GRID = 6;

/**
 * @param {any} model anywidget's, or that of a page without a kernel
 * @param {Promise<typeof import("../tools.js")>} arriving parts that are not needed at once
 */
export function createEditor(model, arriving) {
  const view = Math.random().toString(36).slice(2, 12);
  const ending = new AbortController();
  let frame = 0, calm = 0, catchUp = 0;
  /** Whether an event is being handled after which the editor is drawn. */
  let handling = false;
  let drawn = -1;
  /** @type {typeof import("../tools.js") | null} */
  let tools = null;
  /** @type {import("../lesson/lesson.js").Lesson | null} */
  let lesson = null;
  /** Whether it is shown what the held point can reach; what is known of that; and what it depends on. */
  let reaching = false;
  /** @type {import("./reach.js").Reach | null} */
  let reach = null;
  /** @type {string[]} */
  let asked = [];
  /** Where letters press against something in the present drag. @type {[number, number][]} */
  let touching = [];

  const status = createStatus(request), { say } = status;
  const session = new Session(model, request);
  const drawing = new Drawing();
  drawing.onmove = request;
  const channel = new Channel({
    view,
    send: (message) => model.send(message),
    onAnswer: answered,
    onSilence: silence,
    onIdle: idle,
    // A host spends more on a message than the view on a frame, so the kernel hears of few moves unless the view needs
    // its answers.
    throttle: () => (gestures.grab?.follows ? 0 : session.throttle),
  });
  const marks = createMarks(drawing.overlay);
  const gestures = createGestures({
    drawing, session, channel, atOnce,
    predicted: (place) => say(place.met ? "converged" : "unreachable", placeInWords(place, session)),
    signal: ending.signal,
  });
  const act = (/** @type {(...values: any[]) => void} */ action) => guard((...values) => {
    say("idle", "");
    action(...values);
  });
  const controls = createControls({
    set: act((changes, source) => {
      session.setValues(changes, source);
      meet(session.constraints, source, Object.keys(changes));
    }),
    begin: (source) => session.begin(source),
    lock: act((tag) => session.toggleLock(tag)),
    select: act((letter, how) => session.select(letter, how)),
  }, `vfw-${view}`);
  const toolbar = createToolbar({
    undo: act(() => step("undo")),
    redo: act(() => step("redo")),
    restart: act(() => step("restart")),
    resetAll: act(() => session.resetAll()),
    unpinAll: act(() => session.write({ _pins: [] })),
    share: act((shared) => session.setShared(shared)),
    keepApart: act((apart) => session.write({ avoid_overlaps: apart })),
    teach: act((teaching) => session.write({ teaching })),
    reach: act(() => {
      reaching = !reaching;
      if (!tools) say("idle", LATER);
      again();
    }),
    instance: act((index) => session.setValues(session.word?.instances[index].axes ?? {})),
    save: (what) => (tools ? tools.save(what, session, drawing.layout, say) : say("idle", LATER)),
    zoom: act((steps) => {
      gestures.zoomStep(ZOOM ** steps);
      request();
    }),
    fit: act(() => drawing.fit()),
  });
  const bar = createConstraintBar({
    add: act((kind) => constrain(kind)),
    remove: act((index) => session.write({ constraints: session.constraints.filter((_, i) => i !== index) })),
    change: act((index, value) => meet(session.constraints.map((c, i) => (i === index ? { ...c, value } : c)))),
  });
  toolbar.unpin.after(bar.menu);
  const family = html("div", { class: "vfw-family" });
  const root = html("div", { class: "vfwidget vfwidget-editor" },
    html("div", { class: "vfw-stage" }, family, drawing.svg, toolbar.window),
    html("div", { class: "vfw-bar" }, status.line, status.better, toolbar.element), bar.element, controls.element);
  root.addEventListener("keydown", guard(shortcut), { signal: ending.signal });
  for (const [name, value] of Object.entries({ tabindex: 0, role: "application", [KEEP_KEYS]: "true" })) {
    attr(drawing.svg, name, value);
  }

  // The picture that a saved notebook shows is hidden while there is a live view.
  const snapshot = String(model.get("_snapshot") ?? "");
  if (/^[0-9a-f]+$/.test(snapshot)) root.append(html("style", {}, `.vfw-snapshot-${snapshot} { display: none }`));

  /** @type {[string, (...values: any[]) => void][]} */
  const listeners = [
    ...TRAITS.map((trait) => /** @type {[string, () => void]} */ ([`change:${trait}`, () => session.expire(trait)])),
    ["msg:custom", guard(receive)],
  ];
  for (const [name, listener] of listeners) model.on(name, listener);
  const resizes = new ResizeObserver(() => {
    // Only on a page it is known how far what lies behind the word reaches.
    if (!dragging() && !drawing.fits) drawing.fit(true);
    wait();
    request();
  });
  resizes.observe(drawing.svg);

  /** What tests reach for. */
  Object.assign(root, {
    __vfw: {
      toFont: (/** @type {number} */ x, /** @type {number} */ y) => drawing.toFont(x, y),
      toClient: (/** @type {number} */ x, /** @type {number} */ y) => drawing.toClient(x, y),
      stats: channel.stats,
    },
  });
  arriving.then((arrived) => {
    tools = arrived;
    again();
  }, (error) => say("error", `A part of the editor cannot be loaded: ${error.message}.`));
  render();

  /** Shows everything afresh. */
  function again() {
    session.version++;
    request();
  }

  /** Work that happens at most once a frame. */
  function request() {
    if (!handling) frame ||= requestAnimationFrame(render);
  }

  /**
   * A handler whose result is drawn when it returns. Browsers deliver the moves of a pointer just before a frame, and to
   * ask for a frame there would cost a second one.
   * @param {(event: any) => void} handler
   */
  function atOnce(handler) {
    const guarded = guard(handler);
    return (/** @type {any} */ event) => {
      handling = true;
      guarded(event);
      handling = false;
      render();
    };
  }

  /** A handler that reports what goes wrong and leaves the picture as it is. @param {(...values: any[]) => void} handler */
  function guard(handler) {
    return (/** @type {any[]} */ ...values) => {
      try {
        handler(...values);
      } catch (error) {
        console.error("vfwidget:", error);
        say("error", `Something went wrong in the view: ${/** @type {Error} */ (error)?.message ?? error}`);
      }
    };
  }

  function dragging() {
    return gestures.grab !== null || channel.busy;
  }

  /** Does the view know better than the traits? */
  function ahead() {
    return dragging() || catchUp !== 0;
  }

  function render() {
    cancelAnimationFrame(frame);
    frame = 0;
    guard(update)();
    status.show(session, reaching && !gestures.held ? REACH : HINT);
  }

  function update() {
    const fresh = session.pull(ahead()), { word } = session;
    if (word === null) return;
    if (fresh) {
      gestures.forget();
      attr(drawing.backdrop, "d", session.backdrop);
      drawing.setWord(word, session.axes);
      controls.setWord(word);
      toolbar.setWord(word);
      family.textContent = word.family;
      attr(drawing.svg, "aria-label", `${word.string} in ${word.family}. ${HINT} ${KEYS}`);
    }
    // Read before anything is written, so that the browser lays the page out only once.
    const { pixel } = drawing;
    if (drawn !== session.version) {
      drawn = session.version;
      drawing.draw(session.axes);
      attr(drawing.backdrop, "d", session.backdrop);
      const sets = isArray(session.axes) ? session.axes : [session.axes];
      controls.show(session);
      bar.show(session.constraints, session.pins.length, word.rows[0].lines, (letter) => controls.names[letter] ?? "");
      toolbar.show(session, sets.some((values) => word.axes.some((axis) => values[axis.tag] !== axis.default)), reaching);
      attr(root, "data-theme", session.theme);
      if (session.height === null) root.style.removeProperty("--vfw-height");
      else root.style.setProperty("--vfw-height", `${session.height}px`);
      root.toggleAttribute("data-height", session.height !== null);
      wait();
    }
    gestures.refresh();
    spread(pixel);
    mark(pixel);
    teach();
    if (!channel.busy && session.flush()) settle();
  }

  /** Shows the numbers behind the selected letter, or hides them. */
  function teach() {
    const { teaching, selected, shared } = session, { layout } = drawing, { held } = gestures;
    if (teaching && tools && !lesson) root.append((lesson = new tools.Lesson()).element);
    if (!lesson || layout === null) return;
    lesson.element.hidden = !teaching;
    const letter = held && shared ? held[0] : selected;
    if (teaching) lesson.show(layout, letter, controls.names[letter], held);
  }

  /** Finds more of what the held point can reach, a little in every frame. @param {number} pixel font units a pixel takes */
  function spread(pixel) {
    const { pins, constraints, locks, shared, axes } = session, { held, grab } = gestures, { layout } = drawing;
    if (!reaching || !tools || layout === null || held === null) {
      reach = null;
      asked = [];
      return;
    }
    // Without pins and constraints a word with one axis vector can go to any place from any other.
    const free = shared && pins.length + constraints.length === 0;
    const now = [held, [pins, constraints, locks, ...free ? [] : [axes]]].map((part) => JSON.stringify(part));
    // While a point is dragged, what it can reach stays the same.
    if (now[0] !== asked[0] || (now[1] !== asked[1] && !grab?.drag)) {
      asked = now;
      reach = new tools.Reach(gestures.dragOf(held), layout.position(held), GRID * pixel);
    }
    if (reach?.grow(SHARE)) request();
  }

  /** @param {number} pixel font units a pixel takes */
  function mark(pixel) {
    const { layout } = drawing, { grab, hover, shown: { handle, mode } } = gestures;
    if (layout === null) return;
    const pins = session.pins.flatMap((pin, index) => (layout.has(pin)
      ? [{ at: layout.position(pin), index, hot: hover?.pin === index }] : []));
    // With other glyphs a pin may have no point until the kernel has moved it to one.
    if (pins.length < session.pins.length && layout.word.rows.length === 1) session.problems.set("_pins", "A pin is not on this word.");
    marks.show({
      pixel,
      handle: handle && layout.has(handle) ? layout.position(handle) : null,
      mode,
      tether: grab?.stuck ? grab.target : null,
      pins,
      constraints: session.constraints.flatMap(({ kind, handles, value = 0 }) => (kind === "Width"
        ? layout.ends.map(([, y]) => [[value, y + layout.word.descender], [value, y + layout.word.ascender]])
        : [handles.filter((handle) => layout.has(handle)).map((handle) => layout.position(handle))])),
      touching: grab ? touching : [],
      reach,
      underline: tools?.underlines(layout, session) ?? [],
    });
    attr(drawing.svg, "data-over", grab ? "drag" : hover ? (hover.pin >= 0 ? "pin" : "outline") : "");
  }

  /** Makes the pins a constraint. @param {import("../solver/terms.js").Constraint["kind"]} kind */
  function constrain(kind) {
    const { layout } = drawing;
    if (layout === null) return;
    const handles = kind === "Width" ? [] : session.pins.filter((pin) => layout.has(pin));
    const [[x0, y0], [x1, y1]] = [0, 1].map((i) => (handles[i] ? layout.position(handles[i]) : [0, 0]));
    const value = kind === "Width" ? Math.max(...layout.ends.map(([x]) => x)) : Math.hypot(x1 - x0, y1 - y0);
    session.begin("constraint");
    if (kind !== "Width") session.write({ _pins: [] }, "constraint");
    const constraint = kind === "Width" || kind === "Distance" ? { kind, handles, value } : { kind, handles };
    meet([...session.constraints, constraint], "constraint");
  }

  /**
   * Moves the axes so that the constraints are met, by the least change.
   * @param {import("../solver/terms.js").Constraint[]} constraints @param {string} [source] @param {string[]} [tags] axes to leave as they are
   */
  function meet(constraints, source = "constraint", tags = []) {
    if (session.word === null || (constraints.length === 0 && session.constraints.length === 0)) return;
    const drag = new Drag(session.word, session.axes, { constraints, locks: [...session.locks, ...tags] }), place = drag.to(null, 10 * PATIENCE);
    session.write({ constraints, axes: place.axes }, source);
    if (!place.met) say("unreachable", UNMET);
  }

  /** Asks the model for a step of its history. @param {"undo" | "redo" | "restart"} type */
  function step(type) {
    session.flush();
    clearTimeout(catchUp);
    catchUp = 0;
    try {
      model.send({ type });
    } catch {
      say("silent", UNSENT);
    }
  }

  /** @param {KeyboardEvent} event */
  function shortcut(event) {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const key = event.key.toLowerCase(), redo = key === "y" || (key === "z" && event.shiftKey);
    if (!redo && key !== "z") return;
    event.preventDefault();
    event.stopPropagation();
    say("idle", "");
    step(redo ? "redo" : "undo");
  }

  /** @param {any} message */
  function receive(message) {
    // An answer that comes too late still shows that somebody is there.
    if (channel.receive(message) === "stale" && status.kind === "silent") say("idle", "");
  }

  /** @param {any} answer @param {import("./channel.js").Message} sent */
  function answered(answer, sent) {
    if (!answer.ok) {
      session.expire("axes");
      return say("error", String(answer.error || "The kernel could not compute this drag."));
    }
    try {
      if (!gestures.follow(answer.axes, sent) || !session.take(answer.axes)) return;
    } catch (error) {
      session.expire("axes");
      return say("error", `The kernel sent a malformed answer: ${/** @type {Error} */ (error).message}`);
    }
    if (sent.phase === "up") session.finish(sent.gesture);
    touching = answer.contacts ?? [];
    drawing.layout?.evaluate(session.axes);
    gestures.judge(sent);
    request();
    // Where the view has predicted the answer, it has said so at once, and the words stay.
    if (answer.status && (!gestures.foretold || answer.status !== status.kind)) say(String(answer.status), String(answer.message || ""));
    if (answer.elsewhere) {
      status.offer(guard(() => {
        say("idle", "");
        session.write({ axes: session.conform(answer.elsewhere) });
      }));
    }
  }

  /** @param {import("./channel.js").Message} sent @param {unknown} error why it could not be sent, if so */
  function silence(sent, error) {
    // What the view has computed by itself stays, and goes to the kernel as any other change.
    if (sent.phase === "up") session.write({ axes: session.axes }, DRAG);
    say("silent", error ? UNSENT : BUSY);
  }

  /** Nothing is asked any more: what waited can be written. */
  function idle() {
    settle();
    request();
  }

  /**
   * Gives the traits the last word, once they had time to catch up: until then they may still say
   * what was true a few messages ago.
   */
  function settle() {
    clearTimeout(catchUp);
    catchUp = setTimeout(() => {
      catchUp = 0;
      session.expire("axes");
    }, CATCH_UP);
  }

  /** Fits the window once nothing has moved for a while. */
  function wait() {
    clearTimeout(calm);
    calm = setTimeout(() => {
      if (dragging() || controls.pressed) wait();
      else if (!drawing.fits) drawing.fit();
    }, CALM);
  }

  function destroy() {
    guard(() => {
      gestures.finishKeys();
      gestures.drop();
      channel.close();
      session.flush();
    })();
    for (const [name, listener] of listeners) model.off(name, listener);
    ending.abort();
    resizes.disconnect();
    drawing.hold();
    cancelAnimationFrame(frame);
    clearTimeout(calm);
    clearTimeout(catchUp);
    frame = 0;
    root.remove();
  }

  return { root, destroy };
}
