import assert from "node:assert/strict";
import { test } from "node:test";

import { makeBundle } from "../bundles.js";
import { Game } from "../../play/game.js";

/** @typedef {import("../../messages.js").ServerMessage} ServerMessage */

const MAP = {
  name: "Small",
  title: "Small",
  number: 0,
  mode: "practice",
  description: "",
  walls: [],
  goals: [],
  robots: { blue: { x: 0, y: 0, angle: 0 }, red: { x: 1, y: 0, angle: 0 } },
  items: [{ id: 0, shape: "circle", size: "small", scale: 0.06, mass: 0.1, x: 0.5, y: 0.5, angle: 0 }],
};

/** @param {import("../../messages.js").Phase} phase @param {number} [untilMs] @returns {ServerMessage} */
const room = (phase, untilMs = 0) => ({
  type: "room",
  phase,
  reason: "",
  until_ms: untilMs,
  seats: [],
  spectators: 0,
  recording: true,
  reason_code: "",
  reason_values: {},
});

/** @param {number} epoch @returns {ServerMessage} */
const round = (epoch) => ({
  type: "round",
  index: 0,
  total: 1,
  epoch,
  map: structuredClone(MAP),
  limit_ticks: 500,
  practice: false,
  episode: "e",
});

/** @param {number} epoch @param {number} tick @param {number} timeMs @returns {ServerMessage} */
const keyframe = (epoch, tick, timeMs) => ({
  type: "keyframe",
  epoch,
  tick,
  time_ms: timeMs,
  poses: [
    [0, 0, 0],
    [1, 0, 0],
    [0.5, 0.5, 0],
  ],
  held: [-1, -1],
  delivered: [false],
});

/** @type {ServerMessage} */
const welcome = {
  type: "welcome",
  protocol: 1,
  build: "",
  room: "r",
  mode: "play",
  seats: [{ seat: 0, token: "t" }],
  resume_s: 30,
  join_path: "",
  watch_path: "",
  frames: {},
  study: false,
  pings: false,
};

/** @type {ServerMessage} */
const result = {
  type: "result",
  index: 0,
  outcome: "time",
  ticks: 1,
  delivered: 0,
  items: 1,
  tcr: 0,
  nfd: 0,
  wt_s: 0,
  ac: -1,
  recording: "",
  delivered_by: [[]],
  metrics: { tcr: 0, nfd: 0, wt_s: 0, ac: -1, interdependence: 0.5, of_a_newer_server: 1 },
};

/**
 * @param {number} tick
 * @param {number} timeMs
 * @param {number} x
 * @param {number} [epoch]
 * @returns {import("../../messages.js").Bundle}
 */
function bundle(tick, timeMs, x, epoch = 1) {
  return makeBundle(() => x, { tick, timeMs, epoch });
}

/** @param {Game} game */
const outcome = (game) => game.result?.outcome ?? "none yet";

/** A game whose clock equals the local one, playing since time 0. */
function playing() {
  const game = new Game();
  for (const message of [welcome, round(1), keyframe(1, 0, 0), room("playing")]) game.receive(message, 0);
  game.clock.add(0, 0, 0);
  return game;
}

test("before the first bundle the map's start is shown, with the seats of this page", () => {
  const game = new Game();
  assert.equal(game.show(0), null);
  game.receive(welcome, 0);
  game.receive(round(1), 0);
  assert.deepEqual(game.show(0)?.view.poses[1], [1, 0, 0]);
  assert.deepEqual(game.own, [0]);
});

test("the result waits until the picture has reached the end of the round", () => {
  const game = playing();
  game.addBundle(bundle(1, 1000, 0.5), 1000);
  game.show(1016);
  game.receive(result, 1017);
  game.receive(room("series_over"), 1017);
  game.show(1050);
  assert.equal(outcome(game), "none yet");
  assert.equal(game.phase, "playing");
  for (let now = 1060; now < 1200; now += 16) game.show(now);
  assert.equal(outcome(game), "time");
  assert.equal(game.phase, "series_over");
});

test("news never waits longer than 400 ms, even before the clock is known", () => {
  const game = new Game();
  for (const message of [welcome, round(1), keyframe(1, 0, 0), room("playing")]) game.receive(message, 0);
  game.receive(result, 1000);
  game.show(1300);
  assert.equal(outcome(game), "none yet");
  game.show(1400);
  assert.equal(outcome(game), "time");
});

test("without data the game says that it is stalled, but not in a pause and not at the end", () => {
  const game = playing();
  game.addBundle(bundle(1, 1000, 0.5), 1000);
  for (let now = 1000; now < 1400; now += 16) game.show(now);
  assert.equal(game.show(1400)?.stalled, true);
  game.receive(room("paused"), 1401);
  assert.equal(game.show(1416)?.stalled, false);
});

test("bundles of another round are not drawn", () => {
  const game = playing();
  game.addBundle(bundle(1, 1000, 0.5, 2), 1000);
  assert.equal(game.newestTick, 0);
});

test("a new round starts from its own map, and the old result is gone", () => {
  const game = playing();
  game.show(50);
  game.receive(room("round_over"), 60);
  game.receive(result, 60);
  assert.equal(outcome(game), "time");
  game.receive(round(2), 70);
  assert.equal(outcome(game), "none yet");
  assert.equal(game.newestTick, 0);
});

test("after coming back the server's state counts, even when its tick is older than what was known", () => {
  const game = playing();
  for (let tick = 1; tick <= 5; tick += 1) game.addBundle(bundle(tick, 100 * tick, 0.9), 100 * tick);
  assert.equal(game.newestTick, 5);
  for (const message of [welcome, round(1), keyframe(1, 3, 50)]) game.receive(message, 700);
  assert.equal(game.newestTick, 3);
  game.clock.add(700, 100, 700);
  assert.deepEqual(game.show(760)?.view.poses[0], [0, 0, 0]);
});

test("the countdown runs by the server's clock", () => {
  const game = playing();
  game.receive(room("countdown", 5000), 0);
  assert.equal(game.secondsLeft(2000), 3);
  assert.equal(game.secondsLeft(9000), 0);
});

test("a result has its metrics decoded: what has no value is null", () => {
  const game = new Game();
  game.receive(result, 0);
  assert.deepEqual(game.result?.metrics, { tcr: 0, nfd: 0, wt_s: 0, ac: null, interdependence: 0.5 });
  game.receive({ ...result, metrics: {} }, 0);
  assert.deepEqual(game.result?.metrics, { tcr: 0, nfd: 0, wt_s: 0, ac: null });
});
