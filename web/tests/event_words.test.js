// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { eventTone, eventWords, isTold, tickTime } from "../event_words.js";

const POSE = { x: 0, y: 0, angle: 0 };
const ITEM = { id: 0, shape: "star", size: "large", scale: 0.1, mass: 6, ...POSE };
const MAP = { name: "", title: "", number: 1, mode: "", description: "", robots: { blue: POSE, red: POSE }, walls: [], goals: [], items: [ITEM] };

/** @param {string} kind */
const event = (kind, seat = 1, item = 0) => ({ tick: 3, kind, seat, item, detail: "" });

test("events are sentences with seat and item", () => {
  assert.equal(eventWords(event("grab"), MAP), "Red takes the large star");
  assert.equal(eventWords(event("delivered", -1), MAP), "The large star is delivered");
  assert.equal(eventWords(event("release", 0, 7), MAP), "Blue lets the item go");
});

test("start, end and collisions are no lines of their own", () => {
  assert.deepEqual(["start", "collision", "end", "grab", "deadline_missed"].map((kind) => isTold(event(kind))), [false, false, false, true, true]);
});

test("marks have the colour of the seat, of a delivery or of a problem", () => {
  assert.deepEqual([event("grab", 0), event("release", 1), event("delivered"), event("grab_failed")].map(eventTone), ["blue", "red", "ok", "attention"]);
});

test("ticks are shown as minutes, seconds and tenths", () => {
  assert.deepEqual([0, 9, 123, 600, 1234].map(tickTime), ["0:00.0", "0:00.9", "0:12.3", "1:00.0", "2:03.4"]);
});
