import assert from "node:assert/strict";
import { beforeEach, mock, test } from "node:test";

import { Connection } from "../../wire/connection.js";
import * as wire from "../../messages.js";
import { speak } from "../text/support.js";

speak("en");

class FakeSocket {
  static OPEN = 1;
  /** @type {FakeSocket[]} */
  static all = [];
  readyState = 0;
  /** @type {(string | ArrayBuffer)[]} */
  sent = [];
  /** @type {any} */ onopen;
  /** @type {any} */ onmessage;
  /** @type {any} */ onclose;

  /** @param {string} url @param {string} protocol */
  constructor(url, protocol) {
    this.url = url;
    this.protocol = protocol;
    FakeSocket.all.push(this);
  }

  /** @param {string | ArrayBuffer} frame */
  send(frame) {
    this.sent.push(frame);
  }

  close() {
    this.readyState = 3;
  }

  opens() {
    this.readyState = FakeSocket.OPEN;
    this.onopen();
  }

  /** @param {object} message */
  says(message) {
    this.onmessage({ data: JSON.stringify(message) });
  }

  /** @param {number} code */
  closes(code) {
    this.readyState = 3;
    this.onclose({ code });
  }

  get joined() {
    return JSON.parse(String(this.sent[0]));
  }
}

const newest = () => /** @type {FakeSocket} */ (FakeSocket.all.at(-1));
const KEY = "movingout.tokens.abc";
/** @type {Map<string, string>} */
const storage = new Map();
const shared = new Map(); // what the next tab sees too
/** @type {(() => void)[]} */
let hides = [];
/** @type {(() => void)[]} */
let onlines = [];
/** @type {string[]} */
let statuses = [];

/** @param {wire.Mode} [mode] */
function connect(mode = "play") {
  statuses = [];
  const connection = new Connection("abc", mode, {
    onMessage: () => {},
    onBundle: () => {},
    onPong: () => {},
    onStatus: (status, ending, why) =>
      statuses.push([status, ...(ending ? [ending.sentence] : []), ...(why ? [why] : [])].join(": ")),
  });
  connection.open();
  return connection;
}

/** @param {Partial<wire.Welcome>} [more] */
const welcome = (more) => ({
  type: "welcome",
  protocol: wire.PROTOCOL,
  build: "",
  room: "abc",
  mode: "play",
  seats: [{ seat: 0, token: "second" }],
  resume_s: 30,
  join_path: "",
  watch_path: "",
  ...more,
});

beforeEach(() => {
  FakeSocket.all = [];
  storage.clear();
  shared.clear();
  hides = [];
  onlines = [];
  mock.timers.reset();
  mock.timers.enable({ apis: ["setTimeout"] });
  Object.assign(globalThis, {
    WebSocket: FakeSocket,
    location: { protocol: "http:", host: "host:1" },
    addEventListener: (/** @type {string} */ kind, /** @type {() => void} */ act) => {
      if (kind === "pagehide") hides.push(act);
      if (kind === "online") onlines.push(act);
    },
    localStorage: {
      getItem: (/** @type {string} */ key) => shared.get(key) ?? null,
      setItem: (/** @type {string} */ key, /** @type {string} */ value) => shared.set(key, value),
      removeItem: (/** @type {string} */ key) => shared.delete(key),
    },
    sessionStorage: {
      getItem: (/** @type {string} */ key) => storage.get(key) ?? null,
      setItem: (/** @type {string} */ key, /** @type {string} */ value) => storage.set(key, value),
    },
  });
});

test("the first message joins with the seats of this tab, and the new token is kept", () => {
  storage.set(KEY, '["first"]');
  connect();
  newest().opens();
  assert.equal(newest().url, "ws://host:1/ws/abc");
  assert.deepEqual(newest().joined, { type: "join", room: "abc", mode: "play", tokens: ["first"], claim: 0 });
  newest().says(welcome());
  assert.equal(storage.get(KEY), '["second"]');
  assert.deepEqual(statuses, ["open"]);
});

test("a new tab takes the seat that a closed one has left, and only one tab does", () => {
  storage.set(KEY, '["mine"]');
  connect();
  hides.forEach((hide) => hide());
  storage.clear(); // the tab is closed
  connect();
  newest().opens();
  assert.deepEqual([newest().joined.tokens, newest().joined.claim], [["mine"], 0]);
  storage.clear(); // a third tab, while the second plays
  connect();
  newest().opens();
  assert.deepEqual([newest().joined.tokens, newest().joined.claim], [[], 1]);
});

test("a reloaded tab keeps its own seat and leaves nothing behind", () => {
  storage.set(KEY, '["mine"]');
  connect();
  hides.forEach((hide) => hide());
  connect();
  assert.equal(storage.get(KEY), '["mine"]');
  assert.equal(shared.size, 0);
});

test("somebody with the link claims a seat, a spectator none", () => {
  connect();
  newest().opens();
  assert.equal(newest().joined.claim, 1);
  connect("watch");
  newest().opens();
  assert.deepEqual([newest().joined.claim, newest().joined.mode], [0, "watch"]);
});

test("a lost connection is tried again after 100 ms, then ever later, at most 5 s apart", () => {
  connect();
  newest().opens();
  newest().says(welcome());
  newest().closes(1006);
  assert.deepEqual(statuses, ["open", "reconnecting"]);
  mock.timers.tick(79);
  assert.equal(FakeSocket.all.length, 1);
  mock.timers.tick(42);
  assert.equal(FakeSocket.all.length, 2);
  for (let tries = 0; tries < 8; tries += 1) {
    newest().opens();
    newest().closes(1006);
    mock.timers.tick(6001);
  }
  assert.equal(FakeSocket.all.length, 10);
});

test("after some close codes it is over, with a sentence", () => {
  for (const code of [wire.CLOSE_KICKED, wire.CLOSE_REPLACED, wire.CLOSE_ROOM_OVER, wire.CLOSE_NOT_FOUND]) {
    connect();
    newest().opens();
    newest().closes(code);
    assert.match(String(statuses.at(-1)), /^over: \S.+\.$/);
    const sockets = FakeSocket.all.length;
    mock.timers.tick(60_000);
    assert.equal(FakeSocket.all.length, sockets);
  }
});

test("the reason that the server gives for its goodbye is what people read", () => {
  connect();
  newest().opens();
  newest().says({ type: "bye", code: wire.CLOSE_ROOM_OVER, message: "", error: "nobody_here", values: {} });
  newest().closes(wire.CLOSE_ROOM_OVER);
  assert.equal(statuses.at(-1), "over: This game was closed because nobody was here for a while.");
});

test("while a room is at another machine, its page says so and keeps trying, at least once a second", () => {
  connect();
  for (let time = 0; time < 8; time += 1) {
    newest().opens();
    newest().says({ type: "bye", code: wire.CLOSE_SHUTDOWN, message: "", error: "moving", values: {} });
    const sockets = FakeSocket.all.length;
    newest().closes(wire.CLOSE_SHUTDOWN);
    assert.match(String(statuses.at(-1)), /^reconnecting: This game is moving to another machine/);
    mock.timers.tick(1200);
    assert.equal(FakeSocket.all.length, sockets + 1);
  }
});

test("a key that is not valid any more is forgotten, and the link tried once without it", () => {
  storage.set(KEY, '["stale"]');
  connect();
  newest().opens();
  newest().closes(wire.CLOSE_UNAUTHORISED);
  mock.timers.tick(1);
  newest().opens();
  assert.deepEqual([newest().joined.tokens, newest().joined.claim], [[], 1]);
  newest().closes(wire.CLOSE_UNAUTHORISED);
  assert.match(String(statuses.at(-1)), /^over/);
});

test("a server of another protocol asks for a reload", () => {
  connect();
  newest().opens();
  newest().says(welcome({ protocol: wire.PROTOCOL + 1 }));
  assert.match(String(statuses.at(-1)), /reload/);
});

/** Handshakes refused one after the other, each with time for the page to ask why. @param {number} times */
async function refuse(times) {
  for (let time = 0; time < times; time += 1) {
    newest().closes(1006);
    await new Promise((done) => setImmediate(done)); // the page asks and hears the answer
    mock.timers.tick(6001);
  }
}

test("a server that comes back between a refused handshake and the question why is no reason to reload", async () => {
  let up = false;
  Object.assign(globalThis, { fetch: async () => (up ? Response.json({}) : Promise.reject(new TypeError("refused"))) });
  connect();
  newest().opens();
  newest().says(welcome());
  await refuse(6);
  up = true;
  await refuse(1);
  newest().opens();
  newest().says(welcome());
  assert.deepEqual([statuses.at(-1), statuses.filter((status) => status.startsWith("over"))], ["open", []]);
});

test("handshakes that a server of another protocol keeps refusing ask for a reload", async () => {
  Object.assign(globalThis, { fetch: async () => Response.json({ subprotocol: "movingout.v99" }) });
  connect();
  await refuse(8);
  assert.match(String(statuses.at(-1)), /^over: .*reload/);
});

test("handshakes that a server of this protocol refuses are tried on, and people read why", async () => {
  storage.set(KEY, '["mine"]');
  Object.assign(globalThis, { fetch: async () => Response.json({ subprotocol: wire.SUBPROTOCOL }) });
  connect();
  await refuse(2);
  assert.equal(statuses.at(-1), "reconnecting");
  await refuse(8);
  assert.match(String(statuses.at(-1)), /^reconnecting: The server takes no live connection right now/);
  newest().opens();
  newest().says(welcome());
  assert.deepEqual([newest().joined.tokens, statuses.at(-1)], [["mine"], "open"]);
  newest().closes(1006);
  assert.equal(statuses.at(-1), "reconnecting");
});

test("people read the same where handshakes are swallowed, as by a proxy", async () => {
  Object.assign(globalThis, { fetch: async () => Response.json({ subprotocol: wire.SUBPROTOCOL }) });
  connect();
  for (let time = 0; time < 8; time += 1) {
    mock.timers.tick(10_000);
    await new Promise((done) => setImmediate(done));
    mock.timers.tick(6001);
  }
  assert.match(String(statuses.at(-1)), /^reconnecting: The server takes no live connection right now/);
});

test("nothing is sent into a socket that is not open", () => {
  const connection = connect();
  assert.equal(connection.send({ type: "keyframe" }), false);
  newest().opens();
  assert.equal(connection.send({ type: "keyframe" }), true);
});

test("a handshake that nobody answers is given up and tried again, ever later", () => {
  connect();
  mock.timers.tick(9999);
  assert.deepEqual([FakeSocket.all.length, statuses], [1, []]);
  mock.timers.tick(1);
  mock.timers.tick(120);
  assert.deepEqual([FakeSocket.all.length, FakeSocket.all[0].readyState, statuses], [2, 3, ["reconnecting"]]);
  FakeSocket.all[0].closes(1006); // at last, and nobody waits for it any more
  mock.timers.tick(9000);
  assert.equal(FakeSocket.all.length, 2);
  newest().opens();
  newest().says(welcome());
  mock.timers.tick(60);
  assert.equal(statuses.at(-1), "open");
  assert.equal(FakeSocket.all.length, 2);
});

test("a network that is back while a socket connects replaces it: only one joins", () => {
  storage.set(KEY, '["first"]');
  connect();
  onlines.forEach((online) => online());
  mock.timers.tick(0);
  const [before, after] = FakeSocket.all;
  assert.equal(before.readyState, 3);
  after.opens();
  before.opens();
  after.says(welcome());
  before.says(welcome({ seats: [{ seat: 0, token: "of the other" }] }));
  before.closes(1006);
  assert.deepEqual([before.sent, after.joined.tokens], [[], ["first"]]);
  assert.deepEqual([statuses, storage.get(KEY)], [["open"], '["second"]']);
});

test("why the server closes a connection that is tried again is what people read, if it helps them", () => {
  connect("watch");
  for (const [error, words] of /** @type {const} */ ([
    ["watchers_full", "reconnecting: Too many people are already watching. Try again later."],
    ["too_slow", "reconnecting: Your connection is too slow for the game. Check your network."],
    ["bad_request", "reconnecting"],
    ["of_a_newer_server", "reconnecting"],
  ])) {
    newest().opens();
    newest().says({ type: "bye", code: wire.CLOSE_RETRY_LATER, message: "", error, values: {} });
    newest().closes(wire.CLOSE_RETRY_LATER);
    assert.equal(statuses.at(-1), words);
    mock.timers.tick(6001);
  }
});
