// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { eventTone, eventWords, tickTime, shownEvents } from "../../replay/event_words.js";
import { speak } from "../text/support.js";

speak("en");

const POSE = { x: 0, y: 0, angle: 0 };
const ITEM = { id: 0, shape: "star", size: "large", scale: 0.1, mass: 6, ...POSE };
const MAP = {
  name: "",
  title: "",
  number: 1,
  mode: "",
  description: "",
  robots: { blue: POSE, red: POSE },
  walls: [],
  goals: [],
  items: [ITEM],
};

/** @param {string} kind */
const event = (kind, seat = 1, item = 0) => ({ tick: 3, kind, seat, item, detail: "" });

test("events are sentences with seat and item", () => {
  assert.equal(eventWords(event("grab"), MAP), "Red takes the large star");
  assert.equal(eventWords(event("delivered", -1), MAP), "The large star is delivered");
  assert.equal(eventWords(event("release", 0, 7), MAP), "Blue lets go of the item");
  assert.equal(eventWords(event("unseen_map"), MAP), "Red was not trained on this map");
  assert.equal(eventWords(event("ping"), MAP), "Red asks for help: large star");
  assert.equal(eventWords(event("ping", 0, -1), MAP), "Blue asks for help");
  assert.equal(eventWords(event("unheard_of"), MAP), "unheard_of");
});

test("events are told in the reader's language", () => {
  speak("de");
  assert.equal(eventWords(event("grab"), MAP), "Rot nimmt: Stern (groß)");
  speak("en");
});

test("start and end are no lines of their own", () => {
  const events = ["start", "collision", "end", "grab", "deadline_missed"].map((kind) => event(kind));
  assert.deepEqual(
    shownEvents(events, 50).map(({ kind }) => kind),
    ["collision", "grab", "deadline_missed"],
  );
});

test("what ended a round in the midst of a tick stands where the time line ends", () => {
  const lost = { ...event("drop"), tick: 51 };
  assert.deepEqual(
    shownEvents([lost, { ...event("grab"), tick: 50 }], 50).map(({ kind, tick }) => [kind, tick]),
    [
      ["grab", 50],
      ["drop", 50],
    ],
  );
});

test("the same trouble many times in a row is one line, what players do never is", () => {
  const at = (/** @type {number} */ tick, /** @type {string} */ kind, seat = 1) => ({ ...event(kind, seat), tick });
  const events = [
    at(2, "deadline_missed"),
    at(3, "deadline_missed"),
    at(3, "deadline_missed", 0),
    at(4, "deadline_missed"),
    at(5, "grab"),
    at(6, "release"),
    at(7, "grab"),
    at(60, "deadline_missed"),
  ];
  const shown = shownEvents(events, 99);
  assert.deepEqual(
    shown.map(({ tick, seat, times }) => [tick, seat, times]),
    [
      [2, 1, 3],
      [3, 0, 1],
      [5, 1, 1],
      [6, 1, 1],
      [7, 1, 1],
      [60, 1, 1],
    ],
  );
  assert.equal(eventWords(shown[0], MAP), "Red answered too late, 3 times");
});

test("marks have the colour of the seat, of a delivery or of a problem", () => {
  assert.deepEqual([event("grab", 0), event("release", 1), event("delivered"), event("grab_failed")].map(eventTone), [
    "blue",
    "red",
    "ok",
    "attention",
  ]);
});

test("ticks are shown as minutes, seconds and tenths", () => {
  assert.deepEqual([0, 9, 123, 600, 1234].map(tickTime), ["0:00.0", "0:00.9", "0:12.3", "1:00.0", "2:03.4"]);
  speak("de");
  assert.equal(tickTime(123), "0:12,3");
  speak("en");
});
