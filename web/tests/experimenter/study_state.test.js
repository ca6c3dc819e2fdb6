// @ts-check
import assert from "node:assert/strict";
import test from "node:test";

import { merged } from "../../experimenter/study_state.js";

/** @param {string} pid @param {string} step */
const row = (pid, step) => /** @type {any} */ ({ pid, step });

test("the first news are the whole state", () => {
  const whole = /** @type {any} */ ({ paused: false, participants: [row("P1", "consent")] });
  assert.equal(merged(null, whole), whole);
  assert.equal(merged(/** @type {any} */ ({ participants: [row("P0", "code")] }), whole), whole);
});

test("changed rows replace theirs, new ones follow, gone ones leave, and the others stay the same objects", () => {
  const before = /** @type {any} */ ({ paused: false, participants: [row("P1", "form"), row("P2", "form")] });
  const news = /** @type {any} */ ({ paused: true, partial: true, participants: [row("P2", "round")], gone: [] });
  const after = /** @type {any} */ (merged(before, news));
  assert.equal(after.paused, true);
  assert.equal(after.participants[0], before.participants[0]);
  assert.equal(after.participants[1].step, "round");
  const more = /** @type {any} */ (merged(after, { more: [row("P3", "consent")] }));
  assert.deepEqual(
    more.participants.map((/** @type {any} */ one) => one.pid),
    ["P1", "P2", "P3"],
  );
  assert.equal(more.paused, true);
  const left = /** @type {any} */ (
    merged(more, /** @type {any} */ ({ partial: true, participants: [], gone: ["P1"] }))
  );
  assert.equal(left.participants.length, 2);
});
