// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

/** @type {any} */ (globalThis).window = {};
const { Probe } = await import("../../play/probe.js");

/** Whether a page whose pictures come this often is slow, asked after every picture. @param {number} gapMs */
function answers(gapMs) {
  const probe = new Probe(/** @type {any} */ ({}));
  return Array.from({ length: 120 }, (_, index) => {
    probe.drawn(index * gapMs, null, "open", [null, null]);
    return probe.isSlow;
  });
}

test("a page that misses every second picture is found slow, once", () => {
  assert.equal(answers(33).filter(Boolean).length, 1);
  assert.equal(answers(33).indexOf(true), 59);
});

test("a page that keeps up is not slow, at 60 Hz and at 144 Hz", () => {
  assert.ok(!answers(1000 / 60).some(Boolean));
  assert.ok(!answers(1000 / 144).some(Boolean));
});
