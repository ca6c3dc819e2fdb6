// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { ApiError } from "../../core/api.js";
import { Persistence } from "../../study/persistence.js";

test("a server that is away is asked ever later, a refusal is passed on at once", async () => {
  /** @type {number[]} */
  const waits = [];
  /** @type {boolean[]} */
  const states = [];
  const persistence = new Persistence(
    (offline) => states.push(offline),
    async (ms) => void waits.push(ms),
  );
  let tries = 0;
  const answer = await persistence.until(async () => {
    tries += 1;
    if (tries < 7) throw new ApiError("offline", "", tries === 3 ? 503 : tries === 4 ? 408 : 0);
    return "here";
  });
  assert.deepEqual([answer, waits, states.at(-1)], ["here", [500, 1000, 2000, 4000, 4000, 4000], false]);
  await assert.rejects(
    persistence.until(async () => Promise.reject(new ApiError("not_saved", "full", 507))),
    /full/,
  );
  assert.equal(waits.length, 6);
});
