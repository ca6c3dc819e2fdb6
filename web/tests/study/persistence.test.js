// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { ApiError } from "../../core/api.js";
import { Persistence } from "../../study/persistence.js";

test("a server that is away is asked ever later, a refusal is passed on at once", async () => {
  /** @type {number[]} */
  const waits = [];
  /** @type {(ApiError | null)[]} */
  const states = [];
  const persistence = new Persistence(
    (problem) => states.push(problem),
    async (ms) => void waits.push(ms),
  );
  let tries = 0;
  const answer = await persistence.until(async () => {
    tries += 1;
    if (tries < 7) throw new ApiError("offline", "", tries === 3 ? 503 : tries === 4 ? 408 : 0);
    return "here";
  });
  assert.deepEqual([answer, waits, states.at(-1)], ["here", [500, 1000, 2000, 4000, 4000, 4000], null]);
  await assert.rejects(
    persistence.until(async () => Promise.reject(new ApiError("code_used", "used", 403))),
    /used/,
  );
  assert.equal(waits.length, 6);
});

test("a server that takes nothing for the moment is asked again, one that locks out guesses is not", async () => {
  /** @type {(string | undefined)[]} */
  const states = [];
  const persistence = new Persistence(
    (problem) => states.push(problem?.code),
    async () => {},
  );
  const refusals = [new ApiError("too_many_arrivals", "", 429), new ApiError("not_saved", "", 507)];
  const answer = await persistence.until(async () => {
    const refusal = refusals.shift();
    if (refusal) throw refusal;
    return "here";
  });
  assert.deepEqual([answer, states], ["here", ["too_many_arrivals", "not_saved", undefined]]);
  await assert.rejects(
    persistence.until(async () => Promise.reject(new ApiError("locked", "wait", 429))),
    /wait/,
  );
});
