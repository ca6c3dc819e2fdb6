// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { nextMap, sameSeats } from "../../play/next_game.js";

/** @param {import("../../messages.js").SeatState["kind"]} kind @param {string} [name] */
const seat = (kind, name = "") => ({
  colour: "",
  kind,
  name,
  open: false,
  present: true,
  ready: true,
  device: "",
  rtt_ms: -1,
  visible: true,
});

test("the same partner again: an agent by its id, idle, or both at this screen", () => {
  assert.deepEqual(sameSeats([seat("human"), seat("agent", "bass@all")], [0]), [
    { kind: "here" },
    { kind: "agent", agent: "bass@all" },
  ]);
  assert.deepEqual(sameSeats([seat("idle", "idle"), seat("human")], [1]), [
    { kind: "agent", agent: "idle" },
    { kind: "here" },
  ]);
  assert.deepEqual(sameSeats([seat("human"), seat("human")], [0, 1]), [{ kind: "here" }, { kind: "here" }]);
});

test("nobody is taken along who would have to come: another person, a program, a recording; nor does a watcher", () => {
  for (const kind of /** @type {const} */ (["human", "remote", "ghost"]))
    assert.equal(sameSeats([seat("human"), seat(kind)], [0]), null);
  assert.equal(sameSeats([seat("agent", "a"), seat("agent", "b")], []), null);
});

test("after the last map comes the first, and after an unknown one too", () => {
  assert.equal(nextMap(["a", "b"], "a"), "b");
  assert.equal(nextMap(["a", "b"], "b"), "a");
  assert.equal(nextMap(["a", "b"], "of my own"), "a");
});
