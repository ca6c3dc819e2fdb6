// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { hasBoth, judged, mayJudge, neighbour, nextOpen, wantedFindings } from "../../annotate/queue.js";

/** @param {string} id @param {string} kind @param {boolean} human */
const finding = (id, kind, human = false) => ({
  ...{ id, recording: "r", map: "HandOff", case: kind, seat: 0, item: 0, start: 1, end: 20, human },
});
const A = finding("a", "keeps");
const B = finding("b", "no_grasp", true);
const C = finding("c", "keeps");
const ALL = [A, B, C];
const YES = /** @type {const} */ ({ verdict: "confirmed", note: "" });

test("findings are chosen by case and by who failed", () => {
  assert.deepEqual(wantedFindings(ALL, { kind: "", who: "" }), ALL);
  assert.deepEqual(wantedFindings(ALL, { kind: "keeps", who: "" }), [A, C]);
  assert.deepEqual(wantedFindings(ALL, { kind: "", who: "people" }), [B]);
  assert.deepEqual(wantedFindings(ALL, { kind: "no_grasp", who: "agents" }), []);
});

test("after a verdict the next open finding comes, from the start again after the last", () => {
  assert.equal(nextOpen(ALL, {}, ""), A);
  assert.equal(nextOpen(ALL, { a: YES }, "a"), B);
  assert.equal(nextOpen(ALL, { b: YES, c: YES }, "c"), A);
  assert.equal(nextOpen(ALL, { a: YES, b: YES, c: YES }, "a"), null);
  assert.equal(nextOpen([], {}, ""), null);
});

test("the neighbours end at both ends", () => {
  assert.equal(neighbour(ALL, "b", 1), C);
  assert.equal(neighbour(ALL, "b", -1), A);
  assert.equal(neighbour(ALL, "c", 1), null);
  assert.equal(neighbour(ALL, "gone", 1), A);
  assert.equal(neighbour([], "", -1), null);
});

test("what was not seen cannot be judged, and of what cannot be opened nobody can tell", () => {
  const verdicts = /** @type {const} */ (["confirmed", "rejected", "unsure"]);
  const may = (/** @type {import("../../annotate/queue.js").Sight} */ sight) =>
    verdicts.filter((verdict) => mayJudge(verdict, sight));
  assert.deepEqual([may("loading"), may("shown"), may("unreadable")], [[], [...verdicts], ["unsure"]]);
});

test("only what is shown counts as judged", () => {
  assert.equal(judged(ALL, { a: YES, elsewhere: YES }), 1);
});

test("who failed is a choice only where both did", () => {
  assert.deepEqual([hasBoth(ALL), hasBoth([A, C]), hasBoth([B])], [true, false, false]);
});
