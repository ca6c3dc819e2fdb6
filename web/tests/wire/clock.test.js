import assert from "node:assert/strict";
import { test } from "node:test";

import { ServerClock } from "../../wire/clock.js";

test("the fastest round trip of the last sixteen sets the offset", () => {
  const clock = new ServerClock();
  clock.add(1000, 5100, 1200); // 200 ms there and back
  clock.add(2000, 6010, 2020); // 20 ms: the better witness
  assert.equal(clock.now(20_000), 24_000);
  assert.equal(clock.rttMs, 20);
});

test("a better sample bends the clock by five per cent and never turns it back", () => {
  const clock = new ServerClock();
  clock.add(0, 1000, 200); // offset 900
  clock.add(300, 1110, 320); // offset 800
  const first = clock.now(320);
  const second = clock.now(1320);
  assert.ok(Math.abs(second - first - 950) < 1e-9, `${second - first}`);
  let last = second;
  for (let local = 1320; local < 4000; local += 16) {
    assert.ok(clock.now(local) >= last);
    last = clock.now(local);
  }
  assert.equal(clock.now(10_000), 10_800);
});

test("an old sample is forgotten after sixteen newer ones", () => {
  const clock = new ServerClock();
  clock.add(0, 1000, 2);
  for (let index = 1; index <= 16; index += 1) clock.add(100 * index, 100 * index + 2000 + 20, 100 * index + 40);
  assert.equal(clock.now(1_000_000), 1_002_000);
});

test("a pong from the future is not believed", () => {
  const clock = new ServerClock();
  clock.add(500, 1000, 400);
  assert.equal(clock.known, false);
  assert.equal(clock.rttMs, -1);
});
