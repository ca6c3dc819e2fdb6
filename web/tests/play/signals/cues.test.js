import assert from "node:assert/strict";
import { test } from "node:test";
import { MISS_MS, missAt } from "../../../play/signals/cues.js";

test("a miss moves the notch there and back for 150 ms, and without motion aside", () => {
  assert.equal(missAt(-Infinity, false), 0);
  assert.equal(missAt(Infinity, false), 0);
  assert.ok(missAt(MISS_MS / 8, false) > 0.99);
  assert.ok(missAt((3 * MISS_MS) / 8, false) < -0.99);
  assert.deepEqual([missAt(1, true), missAt(MISS_MS - 1, true), missAt(MISS_MS, true)], [1, 1, 0]);
});
