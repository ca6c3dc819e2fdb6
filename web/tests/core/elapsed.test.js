// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { Elapsed } from "../../core/elapsed.js";

test("a sleep counts in which one of the clocks stands still, and a clock that is set back takes nothing away", () => {
  let [now, wall] = [1000, 50_000];
  const since = new Elapsed(
    () => now,
    () => wall,
  );
  now += 20;
  wall += 20;
  assert.equal(since.ms, 20);
  wall += 60_000; // asleep
  assert.equal(since.ms, 60_020);
  since.restart();
  assert.equal(since.ms, 0);
  now += 500;
  wall -= 3_600_000;
  assert.equal(since.ms, 500);
});
