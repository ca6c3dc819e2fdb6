// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { ANGLE_SCALE, POSITION_SCALE } from "../../messages.js";
import { Replay, ReplayError, episodeIn, linkedTick, tickAt } from "../../replay/data.js";

const POSE = { x: 0, y: 0, angle: 0 };
const ITEM = { id: 0, shape: "circle", size: "small", scale: 0.05, mass: 0.5, ...POSE };
const MAP = {
  name: "One",
  title: "One",
  number: 1,
  mode: "coordination",
  description: "",
  robots: { blue: POSE, red: POSE },
  walls: [],
  goals: [],
  items: [ITEM],
};

/** One tick in which blue walks from x = 0 to 0.5 and turns by `turn`. @param {number} turn */
function oneTick(turn = 0, from = 0, atStart = false) {
  const frames = 6;
  const poses = new DataView(new ArrayBuffer(2 * 3 * 3 * frames));
  for (let frame = 0; frame < frames; frame += 1) {
    const angle = (((from + (turn * frame) / 5) * ANGLE_SCALE + 32768) % 65536) - 32768;
    poses.setInt16(2 * 9 * frame, Math.round(0.1 * frame * POSITION_SCALE), true);
    poses.setInt16(2 * 9 * frame + 4, Math.round(angle), true);
  }
  const summary = {
    id: "a",
    map: MAP,
    started: "",
    limit_ticks: 500,
    ticks: 1,
    outcome: "time",
    complete: true,
    seats: [],
    held: [
      [-1, -1],
      [0, -1],
    ],
    delivered_at_start: [atStart],
    delivered: [[true]],
    events: [],
    metrics: { tcr: 0, nfd: 0, wt_s: 0, ac: null },
    curves: { tcr: [0], nfd: [0], wt_s: [0], ac: [null] },
  };
  return new Replay(summary, poses.buffer);
}

test("poses are exact at 20 ms and on straight lines between", () => {
  const replay = oneTick();
  const x = (/** @type {number} */ ms) => replay.viewAt(ms).poses[0][0].toFixed(3);
  assert.deepEqual([0, 10, 20, 50, 100].map(x), ["0.000", "0.050", "0.100", "0.250", "0.500"]);
});

test("a time outside the episode shows its start or its end", () => {
  const replay = oneTick();
  assert.deepEqual(replay.viewAt(-50), replay.viewAt(0));
  assert.deepEqual(replay.viewAt(900).poses, replay.viewAt(100).poses);
});

test("an angle that wraps between two poses takes the shorter way", () => {
  const replay = oneTick(0.5, Math.PI - 0.25); // passes through pi in the middle of the third pose
  const angle = replay.viewAt(50).poses[0][2];
  assert.ok(Math.abs(Math.abs(angle) - Math.PI) < 0.01, `${angle}`);
});

test("what is held and delivered belongs to the state of the tick", () => {
  const replay = oneTick();
  assert.deepEqual(
    [replay.viewAt(99).held, replay.viewAt(100).held],
    [
      [-1, -1],
      [0, -1],
    ],
  );
  assert.deepEqual([replay.viewAt(99).delivered, replay.viewAt(100).delivered], [[false], [true]]);
});

test("an item that lies in a goal from the start is delivered before the first tick", () => {
  assert.deepEqual(oneTick(0, 0, true).viewAt(0).delivered, [true]);
});

test("poses that do not fit the number of ticks are refused with both numbers", () => {
  const { summary } = oneTick();
  assert.throws(
    () => new Replay({ ...summary, ticks: 2 }, new ArrayBuffer(2 * 9 * 6)),
    (error) => {
      assert.ok(error instanceof ReplayError);
      assert.match(error.message, /6 pictures where 11 belong/);
      return true;
    },
  );
});

test("a tick begins at its hundred milliseconds", () => {
  assert.deepEqual([0, 99.9, 100, 250, 1230].map(tickAt), [0, 0, 1, 2, 12]);
});

test("an address names an episode, also one that was cut in a mail", () => {
  assert.deepEqual(["/replay/a%20b", "/replay/%E0%A4%A"].map(episodeIn), ["a b", "%E0%A4%A"]);
});

test("a deep link names a tick of the episode", () => {
  assert.deepEqual(
    ["#tick=123", "#tick=900", "#tick=", "#tick=-1", "", "#other"].map((hash) => linkedTick(hash, 412)),
    [123, 412, null, null, null, null],
  );
});
