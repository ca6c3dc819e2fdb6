// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { measureRtt, median } from "../../../study/input_check/rtt.js";

test("the round trip is the median of nine, after the two that open the connection", async () => {
  let clock = 0;
  const lengths = [900, 400, 20, 30, 25, 22, 500, 21, 24, 23, 26];
  let asked = 0;
  const rtt = await measureRtt(
    async () => void (clock += lengths[asked++]),
    () => clock,
  );
  assert.deepEqual([rtt, asked], [24, 11]);
  assert.equal(median([1, 4, 2, 3]), 2.5);
});
