// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { clock } from "../../study/pauses.js";

test("times are minutes and seconds", () => {
  assert.deepEqual([0, 9.6, 65, 600, -3].map(clock), ["0:00", "0:10", "1:05", "10:00", "0:00"]);
});
