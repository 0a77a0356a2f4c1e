import assert from "node:assert/strict";
import test from "node:test";
import { Channel } from "../../src/editor/channel.js";

/** A clock that only moves when told to. */
class Clock {
  now = 0;
  events = [];
  setTimeout(callback, ms) {
    const event = { at: this.now + ms, callback };
    this.events.push(event);
    return event;
  }
  clearTimeout(event) {
    this.events = this.events.filter((e) => e !== event);
  }
  advance(ms) {
    const end = this.now + ms;
    for (;;) {
      const next = this.events.filter((e) => e.at <= end).sort((a, b) => a.at - b.at)[0];
      if (!next) break;
      this.clearTimeout(next);
      this.now = next.at;
      next.callback();
    }
    this.now = end;
  }
}

/** A channel and what happened on it; `kernel` is called with each message sent. */
function setUp(kernel = () => {}, options = {}) {
  const clock = new Clock();
  const log = { sent: [], answers: [], silences: [], idle: 0, clock };
  const channel = new Channel({
    view: "v", clock,
    send: (message) => {
      log.sent.push(message);
      kernel(message, clock, (answer) => channel.receive(answer));
    },
    onAnswer: (answer, sent) => log.answers.push([answer, sent]),
    onSilence: (sent, error) => log.silences.push([sent, error]),
    onIdle: () => log.idle++,
    ...options,
  });
  return { channel, log, clock };
}

const body = (phase, x) => ({ phase, handle: [0, 0, 0, 0.5], x, y: 0 });
const reply = ({ seq, view, x }) => ({ type: "drag", view, seq, ok: true, axes: { x } });
const echo = (ms) => (message, clock, receive) => clock.setTimeout(() => receive(reply(message)), ms);

test("120 rapid moves against a 60 ms kernel: few messages, one in flight, quickly settled", () => {
  let inFlight = 0, most = 0;
  const { channel, log, clock } = setUp((message, clock, receive) => {
    most = Math.max(most, ++inFlight);
    clock.setTimeout(() => {
      inFlight--;
      receive(reply(message));
    }, 60);
  });
  channel.push(body("down", 0));
  for (let i = 1; i <= 120; i++) {
    channel.push(body("move", i));
    clock.advance(8);
  }
  channel.push(body("up", 121));
  const released = clock.now;
  while (channel.busy) clock.advance(1);
  assert.equal(most, 1);
  assert.ok(log.sent.length <= 20, `${log.sent.length} messages`);
  assert.ok(clock.now - released <= 130, `settled after ${clock.now - released} ms`);
  assert.deepEqual(log.sent.map((m) => m.seq), log.sent.map((_, i) => i + 1));
  assert.deepEqual([log.sent[0].phase, log.sent[0].x], ["down", 0]);
  assert.deepEqual([log.sent.at(-1).phase, log.sent.at(-1).x], ["up", 121]);
  assert.equal(log.sent.filter((m) => m.phase === "up").length, 1);
  const { sent, answered, replaced, dropped, timedOut } = channel.stats;
  assert.deepEqual([sent, answered, sent + replaced, dropped, timedOut], [log.sent.length, log.sent.length, 122, 0, 0]);
  assert.equal(log.idle, 1);
});

test("all moves at once: down, the latest that fits, up", () => {
  const { channel, log, clock } = setUp(echo(60));
  channel.push(body("down", 0));
  for (let i = 1; i <= 120; i++) channel.push(body("move", i));
  channel.push(body("up", 121));
  clock.advance(1000);
  assert.deepEqual(log.sent.map((m) => [m.phase, m.x]), [["down", 0], ["up", 121]]);
});

test("a second drag neither overtakes nor loses the end of the first", () => {
  const { channel, log, clock } = setUp(echo(500));
  for (const [phase, x] of [["down", 0], ["move", 1], ["up", 2], ["down", 3], ["move", 4], ["move", 5], ["up", 6]]) {
    channel.push(body(phase, x));
  }
  clock.advance(5000);
  assert.deepEqual(log.sent.map((m) => [m.phase, m.x]), [["down", 0], ["up", 2], ["down", 3], ["up", 6]]);
});

test("answers out of order, doubled, foreign or malformed are not taken", () => {
  const { channel, log } = setUp();
  channel.push(body("down", 0));
  channel.push(body("move", 1));
  const [first] = log.sent;
  for (const other of [null, undefined, 5, "drag", {}, { type: "drag", view: "w", seq: 1, ok: true }, { type: "other", view: "v", seq: 1 }]) {
    assert.equal(channel.receive(other), "foreign");
  }
  assert.equal(channel.receive({ ...reply(first), seq: 2 }), "stale"); // not sent yet
  assert.equal(log.answers.length, 0);
  assert.equal(channel.receive(reply(first)), "taken");
  assert.equal(channel.receive(reply(first)), "stale");
  assert.equal(log.sent.length, 2);
  assert.equal(channel.receive(reply(log.sent[1])), "taken");
  assert.equal(channel.receive(reply(first)), "stale"); // nothing in flight
  assert.deepEqual(log.answers.map(([a]) => a.seq), [1, 2]);
  assert.deepEqual([channel.stats.answered, channel.stats.dropped], [2, 3]);
});

test("silence is reported, frees the slot, and a late answer is stale", () => {
  const { channel, log, clock } = setUp((message, clock, receive) => {
    if (message.seq !== 1) echo(10)(message, clock, receive);
  });
  channel.push(body("down", 0));
  channel.push(body("move", 1));
  clock.advance(2999);
  assert.equal(log.silences.length, 0);
  clock.advance(1);
  assert.deepEqual(log.silences.map(([m, error]) => [m.seq, error]), [[1, undefined]]);
  assert.equal(channel.receive(reply(log.sent[0])), "stale");
  clock.advance(10);
  assert.deepEqual(log.answers.map(([a]) => a.seq), [2]);
  assert.deepEqual([channel.stats.timedOut, channel.stats.dropped, channel.busy], [1, 1, false]);
});

test("a kernel that drops every second message: the up is delivered all the same", () => {
  const { channel, log, clock } = setUp((message, clock, receive) => {
    if (message.seq % 2) echo(20)(message, clock, receive);
  }, { timeout: 200 });
  channel.push(body("down", 0));
  for (let i = 1; i <= 100; i++) {
    channel.push(body("move", i));
    clock.advance(8);
  }
  channel.push(body("up", 101));
  clock.advance(2000);
  assert.deepEqual([log.sent.at(-1).phase, log.sent.at(-1).x, channel.busy], ["up", 101, false]);
  assert.ok(log.silences.length > 0 && log.answers.length > 0);
});

test("a dead kernel: one message a timeout, the up last, then quiet", () => {
  const { channel, log, clock } = setUp();
  channel.push(body("down", 0));
  for (let i = 1; i <= 100; i++) channel.push(body("move", i));
  channel.push(body("up", 101));
  clock.advance(60000);
  assert.deepEqual(log.sent.map((m) => m.phase), ["down", "up"]);
  assert.deepEqual([log.silences.length, channel.busy, log.idle, clock.events.length], [2, false, 1, 0]);
});

test("a send that throws is silence with a reason; the next message is tried", () => {
  let broken = true;
  const { channel, log, clock } = setUp((message, clock, receive) => {
    if (broken) throw new Error("no comm");
    echo(5)(message, clock, receive);
  });
  channel.push(body("down", 0));
  assert.match(String(log.silences[0][1]), /no comm/);
  assert.deepEqual([channel.busy, log.idle], [false, 1]);
  broken = false;
  channel.push(body("up", 1));
  clock.advance(5);
  assert.equal(log.answers.length, 1);
});

test("an answer within send, and a listener that throws, do not stop the channel", () => {
  const { channel, log } = setUp((message, clock, receive) => receive(reply(message)));
  for (const phase of ["down", "move", "up"]) channel.push(body(phase, 1));
  assert.deepEqual([log.sent.length, log.answers.length, channel.busy], [3, 3, false]);

  const angry = setUp(undefined, { onAnswer: () => { throw new Error("listener"); } });
  angry.channel.push(body("down", 0));
  angry.channel.push(body("up", 1));
  assert.throws(() => angry.channel.receive(reply(angry.log.sent[0])), /listener/);
  assert.equal(angry.log.sent.length, 2);
});

test("reset forgets; close still sends an up that waits", () => {
  const { channel, log, clock } = setUp();
  channel.push(body("down", 0));
  channel.push(body("move", 1));
  channel.reset();
  assert.deepEqual([channel.busy, clock.events.length, log.sent.length], [false, 0, 1]);
  assert.equal(channel.receive(reply(log.sent[0])), "stale");
  channel.push(body("down", 2));
  channel.push(body("up", 3));
  channel.close();
  assert.deepEqual([log.sent.at(-1).phase, channel.busy, clock.events.length], ["up", false, 0]);
});

test("throttled moves keep their distance; what opens and closes a drag does not wait", () => {
  const times = [], answer = echo(5);
  const { channel, log, clock } = setUp((message, clock, receive) => {
    times.push([message.phase, clock.now]);
    answer(message, clock, receive);
  }, { throttle: () => 100 });
  channel.push(body("down", 0));
  for (let i = 1; i <= 60; i++) {
    clock.advance(5);
    channel.push(body("move", i));
  }
  channel.push(body("up", 61));
  clock.advance(50);
  assert.deepEqual([times[0][0], times.at(-1)[0]], ["down", "up"]);
  const moves = times.filter(([phase]) => phase === "move").map(([, at]) => at);
  assert.ok(moves.length >= 2 && moves.every((at, i) => i === 0 || at - moves[i - 1] >= 100));
  assert.equal(log.answers.at(-1)[1].x, 61);
  assert.equal(channel.busy, false);
});
