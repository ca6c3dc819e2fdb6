import assert from "node:assert/strict";
import { test } from "node:test";

import { makeBundle } from "../bundles.js";
import { between, PlayHead, Timeline } from "../../view/interpolate.js";

/**
 * One robot drives along x from x0, 0.01 per pose; the other and one item stand still.
 * @param {number} tick
 * @param {number} timeMs
 * @param {number} x0
 * @param {Partial<import("../../messages.js").Bundle>} [more]
 * @returns {import("../../messages.js").Bundle}
 */
function bundle(tick, timeMs, x0, more = {}) {
  return makeBundle((pose) => x0 + 0.01 * (pose + 1), { tick, timeMs, ...more });
}

/** @param {Timeline} timeline @param {number} timeMs */
const blueX = (timeline, timeMs) => Number(timeline.at(timeMs)?.poses[0][0].toFixed(6));

test("between two poses the drawing is interpolated", () => {
  const timeline = new Timeline();
  timeline.push(bundle(1, 1000, 0));
  timeline.push(bundle(2, 1100, 0.05));
  assert.equal(blueX(timeline, 1020), 0.01);
  assert.equal(blueX(timeline, 1030), 0.015);
  assert.equal(blueX(timeline, 1110), 0.055);
  assert.equal(timeline.at(1110)?.tick, 1);
  assert.equal(timeline.at(1120)?.tick, 2);
});

test("angles turn by the shorter way, also across the wrap of sixteen bits", () => {
  const [, , angle] = between([0, 0, 3.1], [0, 0, -3.1], 0.5);
  assert.ok(Math.abs(angle - Math.PI) < 1e-9, `${angle}`);
});

test("without data the last velocity goes on for 60 ms, then all stands still", () => {
  const timeline = new Timeline();
  timeline.push(bundle(1, 1000, 0));
  assert.equal(blueX(timeline, 1130), 0.065);
  assert.equal(blueX(timeline, 1160), 0.08);
  assert.equal(blueX(timeline, 5000), 0.08);
});

test("a pause is a standstill, not a slow drift to the next pose", () => {
  const timeline = new Timeline();
  timeline.push(bundle(1, 1000, 0));
  timeline.push(bundle(2, 9000, 0.05));
  assert.equal(blueX(timeline, 8900), 0.05);
  assert.equal(blueX(timeline, 9010), 0.055);
});

test("a bundle that came twice or late changes nothing", () => {
  const timeline = new Timeline();
  timeline.push(bundle(2, 1100, 0));
  timeline.push(bundle(1, 1000, 5));
  timeline.push(bundle(2, 1100, 5));
  assert.equal(timeline.newestTick, 2);
  assert.equal(blueX(timeline, 1150), 0.025);
});

test("grips and deliveries change with the pose that their event names", () => {
  const timeline = new Timeline();
  timeline.push(bundle(1, 1000, 0));
  timeline.push(
    bundle(2, 1100, 0.05, {
      held: [0, -1],
      delivered: [true],
      events: [
        { code: 0, seat: 0, item: 0, pose: 2 },
        { code: 3, seat: -1, item: 0, pose: 4 },
      ],
    }),
  );
  assert.deepEqual(timeline.at(1150)?.held, [-1, -1]);
  assert.deepEqual(timeline.at(1160)?.held, [0, -1]);
  assert.deepEqual(timeline.at(1190)?.delivered, [false]);
  assert.deepEqual(timeline.at(1200)?.delivered, [true]);
});

test("events are held until the play head reaches them, and given once", () => {
  const timeline = new Timeline();
  timeline.push(
    bundle(1, 1000, 0, {
      events: [
        { code: 0, seat: 0, item: 0, pose: 0 },
        { code: 2, seat: 0, item: 0, pose: 4 },
      ],
    }),
  );
  assert.deepEqual(timeline.takeEvents(1019), []);
  assert.deepEqual(
    timeline.takeEvents(1020).map((event) => event.code),
    [0],
  );
  assert.deepEqual(
    timeline.takeEvents(1200).map((event) => event.code),
    [2],
  );
  assert.deepEqual(timeline.takeEvents(1300), []);
});

test("what happened while nothing was drawn is not played back", () => {
  const timeline = new Timeline();
  for (let tick = 1; tick <= 20; tick += 1)
    timeline.push(bundle(tick, 1000 + 100 * tick, 0, { events: [{ code: tick, seat: 0, item: 0, pose: 4 }] }));
  assert.deepEqual(
    timeline.takeEvents(3100).map((event) => event.code),
    [15, 16, 17, 18, 19, 20],
  );
  assert.deepEqual(timeline.takeEvents(3200), []);
});

test("a whole state starts the line, but never throws newer bundles away", () => {
  const timeline = new Timeline();
  /** @param {number} tick */
  const state = (tick) => ({
    type: /** @type {const} */ ("keyframe"),
    epoch: 1,
    tick,
    time_ms: 100 * tick,
    poses: [
      [1, 2, 3],
      [0, 0, 0],
      [0, 0, 0],
    ],
    held: [-1, -1],
    delivered: [false],
  });
  timeline.reset(state(7));
  assert.deepEqual(timeline.at(0)?.poses[0], [1, 2, 3]);
  timeline.push(bundle(8, 700, 0));
  timeline.reset(state(8));
  assert.equal(blueX(timeline, 800), 0.05);
  timeline.reset(state(30));
  assert.equal(timeline.at(0)?.poses[0][0], 1);
});

test("the head plays at real speed, behind the usual delay and a margin for the late ones", () => {
  const head = new PlayHead();
  for (let tick = 0; tick < 100; tick += 1) head.arrived(100 * tick, 100 * tick + (tick % 10 === 0 ? 45 : 20));
  assert.equal(head.delayMs, 45);
  const start = head.advance(10_000, Infinity);
  assert.equal(start, 10_000 - 45);
  assert.ok(Math.abs(head.advance(10_016, Infinity) - start - 16) < 1e-9);
});

test("the margin is at least 8 ms and at most 60 ms", () => {
  const steady = new PlayHead();
  for (let tick = 0; tick < 50; tick += 1) steady.arrived(100 * tick, 100 * tick + 20);
  assert.equal(steady.delayMs, 28);
  const wild = new PlayHead();
  for (let tick = 0; tick < 50; tick += 1) wild.arrived(100 * tick, 100 * tick + 20 + 10 * tick);
  assert.equal(wild.delayMs, 80);
});

test("the head waits 60 ms after the last pose, then catches up by a tenth", () => {
  const head = new PlayHead();
  head.arrived(0, 0);
  head.advance(1000, 1000);
  for (let now = 1000; now <= 1200; now += 10) head.advance(now, 1000);
  assert.equal(head.advance(1200, 1000), 1060);
  assert.ok(Math.abs(head.advance(1210, 2000) - 1071) < 1e-9);
});

test("a head more than 250 ms behind jumps", () => {
  const head = new PlayHead();
  head.arrived(0, 0);
  head.advance(1000, 1000);
  assert.equal(head.advance(3000, 3000), 2992);
});
