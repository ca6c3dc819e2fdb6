import assert from "node:assert/strict";
import { test } from "node:test";

import { ghostRequest } from "../../replay/ghost.js";

test("the person takes one seat and the recording the other", () => {
  assert.deepEqual(ghostRequest("then", 0, 300), {
    maps: [],
    seats: [{ kind: "here" }, { kind: "ghost", recording: "then" }],
    limit_ticks: 300,
  });
  assert.deepEqual(ghostRequest("then", 1, 300).seats, [{ kind: "ghost", recording: "then" }, { kind: "here" }]);
});

test("a recording without a limit is played with the usual one", () => {
  assert.equal("limit_ticks" in ghostRequest("then", 0, 0), false);
});
