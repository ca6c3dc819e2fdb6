// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { PeopleHere } from "../../study/people_here.js";

/**
 * @param {string} kind
 * @param {{code?: string, can_stop?: boolean}} [more]
 * @returns {import("../../study/service.js").View}
 */
const at = (kind, { code, can_stop = true } = {}) => ({
  study: { title: "" },
  language: "en",
  languages: ["en"],
  step: { key: kind, kind, code },
  position: { done: 0, total: 9 },
  can_stop,
});

/** @param {import("../../study/service.js").View[]} views */
const sitting = (...views) => {
  const here = new PeopleHere();
  here.remember(["first", "second"].slice(0, views.length));
  here.take(views);
  return here;
};

test("of two the one stays when the other has declined, at a new list of places", () => {
  const here = sitting(at("round"), at("round"));
  const { places } = here;
  assert.equal(here.take([at("code"), at("round")]), true);
  assert.deepEqual([here.tokens, here.views, here.areTwo], [["second"], [at("round")], false]);
  assert.equal(places.length, 2, "whoever waits for an answer can still compare");
  assert.equal(here.take([at("code")]), false, "nobody is left to stay");
  assert.deepEqual(here.tokens, ["second"]);
});

test("two who have finished are shown one code after the other", () => {
  const here = sitting(at("code", { code: "A" }), at("code", { code: "B" }));
  assert.deepEqual([here.haveFinished, here.turn], [true, [0]]);
  here.turnToOtherCode();
  assert.deepEqual(here.turn, [1]);
  here.forget();
  assert.deepEqual([here.places, here.views], [[], []]);
});

test("only those may stop whose turn it is", () => {
  const here = sitting(at("round"), at("round", { can_stop: false }));
  assert.deepEqual([here.turn, here.whoCanStop], [[0, 1], [0]]);
});
