/**
 * The drag channel. A pointer moves faster than a kernel solves, so at most one message is in flight
 * and of the moves that wait behind it only the latest is kept. The messages that open and close a
 * drag are never dropped or overtaken; an answer that does not come frees the slot and is reported.
 */

/**
 * @typedef {{phase: "down" | "move" | "up", handle: number[], x: number, y: number, axes: any, range: number[], gesture: string}} Body
 * @typedef {Body & {type: "drag", view: string, seq: number}} Message
 * @typedef {{setTimeout: (callback: () => void, ms: number) => any, clearTimeout: (id: any) => void, readonly now: number}} Clock
 */

/** @type {Clock} */
const realClock = {
  setTimeout: (callback, ms) => globalThis.setTimeout(callback, ms),
  clearTimeout: (id) => globalThis.clearTimeout(id),
  get now() {
    return performance.now();
  },
};

export class Channel {
  #clock; #inFlight; #onAnswer; #onIdle; #onSilence; #sentAt; #throttle; #timer; #pause; #send; #seq; #view; #waiting; #timeout;

  /**
   * @param {object} options
   * @param {string} options.view names this view among those of a model
   * @param {(message: Message) => void} options.send
   * @param {(answer: any, sent: Message) => void} [options.onAnswer]
   * @param {(sent: Message, error?: unknown) => void} [options.onSilence] no answer in time, or `send` failed
   * @param {() => void} [options.onIdle] nothing is in flight or waiting any more
   * @param {() => number} [options.throttle] the least number of ms between two moves, at present
   * @param {number} [options.timeout] ms
   * @param {Clock} [options.clock]
   */
  constructor({ view, send, onAnswer, onSilence, onIdle, throttle = () => 0, timeout = 3000, clock = realClock }) {
    this.#view = view;
    this.#send = send;
    this.#onAnswer = onAnswer ?? (() => {});
    this.#onSilence = onSilence ?? (() => {});
    this.#onIdle = onIdle ?? (() => {});
    this.#throttle = throttle;
    this.#timeout = timeout;
    this.#clock = clock;
    this.#seq = 0;
    /** @type {Message | null} */
    this.#inFlight = null;
    /** @type {Body[]} */
    this.#waiting = [];
    /** @type {any} */
    this.#timer = null;
    this.#sentAt = -Infinity;
    /** @type {any} */
    this.#pause = null;
    /** `replaced`: moves that a later one made needless; `dropped`: answers that came too late. */
    this.stats = { sent: 0, answered: 0, replaced: 0, dropped: 0, timedOut: 0 };
  }

  get busy() {
    return this.#inFlight !== null || this.#waiting.length > 0;
  }

  /** @param {Body} body */
  push(body) {
    const last = this.#waiting.length - 1;
    if (last >= 0 && this.#waiting[last].phase === "move" && body.phase !== "down") {
      this.#waiting[last] = body;
      this.stats.replaced++;
    } else {
      this.#waiting.push(body);
    }
    this.#pump();
  }

  /**
   * Hands over a message from the kernel.
   * @param {any} answer
   * @returns {"taken" | "stale" | "foreign"}
   */
  receive(answer) {
    if (answer?.type !== "drag" || answer.view !== this.#view) return "foreign";
    if (this.#inFlight === null || answer.seq !== this.#inFlight.seq) {
      this.stats.dropped++;
      return "stale";
    }
    this.stats.answered++;
    const sent = this.#release();
    this.#settle(() => this.#onAnswer(answer, sent));
    return "taken";
  }

  /** Forgets everything; answers still on their way will be stale. */
  reset() {
    if (this.#inFlight !== null) this.#release();
    this.#waiting = [];
  }

  /** The last act of a view: a closing message that still waits goes out now. */
  close() {
    const last = this.#waiting[this.#waiting.length - 1];
    this.reset();
    if (last?.phase === "up") this.push(last);
    this.reset();
  }

  #pump() {
    while (this.#inFlight === null && this.#waiting.length > 0) {
      const rest = this.#sentAt + this.#throttle() - this.#clock.now;
      if (this.#waiting[0].phase === "move" && rest > 0) {
        this.#clock.clearTimeout(this.#pause);
        this.#pause = this.#clock.setTimeout(() => this.#pump(), rest);
        return;
      }
      this.#sentAt = this.#clock.now;
      const body = /** @type {Body} */ (this.#waiting.shift());
      /** @type {Message} */
      const message = { type: "drag", view: this.#view, seq: ++this.#seq, ...body };
      this.#inFlight = message;
      this.#timer = this.#clock.setTimeout(() => this.#expire(message), this.#timeout);
      this.stats.sent++;
      try {
        this.#send(message);
      } catch (error) {
        if (this.#inFlight === message) this.#release();
        this.#onSilence(message, error);
        if (!this.busy) this.#onIdle();
      }
    }
  }

  /** @param {Message} message */
  #expire(message) {
    if (this.#inFlight !== message) return;
    this.stats.timedOut++;
    this.#release();
    this.#settle(() => this.#onSilence(message));
  }

  /** @returns {Message} */
  #release() {
    const sent = /** @type {Message} */ (this.#inFlight);
    this.#clock.clearTimeout(this.#timer);
    this.#inFlight = null;
    return sent;
  }

  /** A callback that throws must not stop the channel. @param {() => void} report */
  #settle(report) {
    try {
      report();
    } finally {
      if (this.busy) this.#pump();
      else this.#onIdle();
    }
  }
}
