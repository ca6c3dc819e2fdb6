// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { Player, SPEEDS, nextEventTick } from "../../replay/player.js";

const player = () => new Player(10_000, 100);

test("a paused player stays where it is", () => {
  const paused = player();
  paused.advance(500);
  assert.equal(paused.timeMs, 0);
});

test("real time is multiplied by the speed", () => {
  const playing = player();
  playing.toggle();
  playing.speed = 4;
  playing.advance(250);
  assert.equal(playing.timeMs, 1000);
});

test("it stops at the end, and playing again starts over", () => {
  const playing = player();
  playing.toggle();
  playing.seek(9_990);
  playing.advance(100);
  assert.deepEqual([playing.timeMs, playing.playing], [10_000, false]);
  playing.toggle();
  assert.deepEqual([playing.timeMs, playing.playing], [0, true]);
});

test("an empty episode cannot be played", () => {
  const empty = new Player(0, 100);
  empty.toggle();
  assert.equal(empty.playing, false);
});

test("a step pauses and lands on a whole tick", () => {
  const stepping = player();
  stepping.toggle();
  stepping.seek(1_250);
  stepping.step(1);
  assert.deepEqual([stepping.timeMs, stepping.playing], [1_300, false]);
  stepping.seek(1_250);
  stepping.step(-1);
  assert.equal(stepping.timeMs, 1_200);
  stepping.step(-50);
  assert.equal(stepping.timeMs, 0);
});

test("speeds change one by one and stop at the ends", () => {
  const fast = player();
  SPEEDS.forEach(() => fast.changeSpeed(1));
  assert.equal(fast.speed, 8);
  [...SPEEDS, ...SPEEDS].forEach(() => fast.changeSpeed(-1));
  assert.equal(fast.speed, 0.25);
});

test("the next event lies strictly before or after the tick, else the ends", () => {
  const events = [{ tick: 5 }, { tick: 9 }, { tick: 9 }, { tick: 30 }];
  assert.deepEqual([nextEventTick(events, 9, 1, 50), nextEventTick(events, 9, -1, 50)], [30, 5]);
  assert.deepEqual([nextEventTick(events, 30, 1, 50), nextEventTick(events, 5, -1, 50)], [50, 0]);
});
