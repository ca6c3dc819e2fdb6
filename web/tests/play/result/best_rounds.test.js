// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { countRound } from "../../../play/result/best_rounds.js";

/** @returns {Pick<Storage, "getItem" | "setItem">} */
function memory() {
  /** @type {Map<string, string>} */
  const kept = new Map();
  return { getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => void kept.set(key, value) };
}

/** @typedef {import("../../../play/result/best_rounds.js").Round} Round */

/** @param {string} name @param {number} limit @param {number} x @returns {Round} */
function round(name, limit = 500, x = 0) {
  const map = { name, robots: {}, walls: [], goals: [], items: [{ x }] };
  return /** @type {Round} */ (/** @type {unknown} */ ({ index: 0, total: 1, limit_ticks: limit, map }));
}

let number = 0;
/** @param {number} delivered @param {number} ticks @param {string} [recording] */
function result(delivered, ticks, recording = `r${(number += 1)}`) {
  return /** @type {import("../../../play/game.js").RoundResult} */ (
    /** @type {unknown} */ ({ delivered, ticks, recording, items: 4, outcome: "time" })
  );
}

test("the best before is told: more delivered first, then less time", () => {
  const storage = memory();
  assert.equal(countRound(round("HandOff"), result(2, 500), storage), null);
  assert.deepEqual(countRound(round("HandOff"), result(4, 400), storage), { delivered: 2, ticks: 500 });
  assert.deepEqual(countRound(round("HandOff"), result(4, 450), storage), { delivered: 4, ticks: 400 });
  assert.deepEqual(countRound(round("HandOff"), result(3, 500), storage), { delivered: 4, ticks: 400 });
});

test("another map, other items or another limit is another best", () => {
  const storage = memory();
  countRound(round("HandOff"), result(4, 300), storage);
  for (const other of [round("LeftRight"), round("HandOff", 900), round("HandOff", 500, 0.5)])
    assert.equal(countRound(other, result(1, 500), storage), null);
});

test("a round that is shown again after a reload is not compared with itself", () => {
  const storage = memory();
  countRound(round("HandOff"), result(2, 500), storage);
  const shown = result(3, 500, "same");
  assert.deepEqual(countRound(round("HandOff"), shown, storage), { delivered: 2, ticks: 500 });
  assert.deepEqual(countRound(round("HandOff"), shown, storage), { delivered: 2, ticks: 500 });
});

test("what is no best round under our key is written over, so that later rounds are kept again", () => {
  for (const broken of ["[1", "[]", "null", '"x"', '{"HandOff": 3}']) {
    const storage = memory();
    storage.setItem("movingout.best", broken);
    assert.equal(countRound(round("HandOff"), result(2, 500), storage), null);
    assert.deepEqual(countRound(round("HandOff"), result(4, 400), storage), { delivered: 2, ticks: 500 });
  }
});

test("what somebody else keeps under our key, or no storage at all, is no reason to fail", () => {
  const broken = { getItem: () => "[1", setItem: () => {} };
  assert.equal(countRound(round("HandOff"), result(1, 1), broken), null);
  const none = {
    getItem: () => {
      throw new Error("forbidden");
    },
    setItem: () => {},
  };
  assert.equal(countRound(round("HandOff"), result(1, 1), none), null);
});
