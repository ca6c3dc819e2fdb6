// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { loadTokens, saveTokens } from "../../wire/seat_tokens.js";

/** A tab's storage that takes no more. @param {string} kept what it has already */
const full = (kept) => ({
  getItem: () => kept,
  setItem: () => {
    throw new DOMException("full", "QuotaExceededError");
  },
});

/** @param {PropertyDescriptor} how */
const storage = (how) => Object.defineProperty(globalThis, "sessionStorage", { configurable: true, ...how });

const forbidden = {
  get() {
    throw new DOMException("forbidden", "SecurityError");
  },
};

test("where storage is forbidden or full a page that lost its connection still knows its seats", () => {
  storage(forbidden);
  saveTokens("abc", ["blue", null]);
  assert.deepEqual([loadTokens("abc"), loadTokens("other")], [["blue"], []]);
  storage({ value: full('["old"]') });
  saveTokens("abc", ["new"]);
  assert.deepEqual(loadTokens("abc"), ["new"]);
  saveTokens("abc", []);
  assert.deepEqual(loadTokens("abc"), []);
});

test("what is stored counts as soon as it can be: another page of this tab may have changed it", () => {
  storage(forbidden);
  saveTokens("abc", ["first"]);
  const kept = new Map();
  const setItem = (/** @type {string} */ key, /** @type {string} */ text) => kept.set(key, text);
  storage({ value: { getItem: (/** @type {string} */ key) => kept.get(key) ?? null, setItem } });
  saveTokens("abc", ["second"]);
  kept.set("movingout.tokens.abc", '["third"]');
  assert.deepEqual(loadTokens("abc"), ["third"]);
});
