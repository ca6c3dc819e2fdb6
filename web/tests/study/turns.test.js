// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { seatsToTake, stillHere, whoseTurn } from "../../study/turns.js";

/**
 * @param {string} kind
 * @param {string} [key]
 * @param {number} [done]
 * @returns {import("../../study/service.js").View}
 */
const at = (kind, key = kind, done = 0) => ({
  study: { title: "" },
  language: "en",
  languages: ["en"],
  step: { key, kind },
  position: { done, total: 9 },
  can_stop: true,
});

test("one person is always asked", () => {
  assert.deepEqual(whoseTurn([at("round")]), [0]);
  assert.deepEqual(whoseTurn([at("code")]), [0]);
});

test("of two, whoever has something to do alone comes before what both do together", () => {
  assert.deepEqual(whoseTurn([at("consent"), at("consent")]), [0]);
  assert.deepEqual(whoseTurn([at("input-check"), at("form")]), [1]);
  assert.deepEqual(whoseTurn([at("questionnaire"), at("round")]), [0]);
});

test("two at the same step that is done together are both asked", () => {
  for (const kind of ["input-check", "practice", "round", "waiting", "break", "paused"]) {
    assert.deepEqual(whoseTurn([at(kind), at(kind)]), [0, 1]);
  }
});

test("of two at different rounds the one behind is shown, and nobody waits for somebody who has finished", () => {
  assert.deepEqual(whoseTurn([at("round", "b", 7), at("round", "a", 6)]), [1]);
  assert.deepEqual(whoseTurn([at("code"), at("debrief")]), [1]);
  assert.deepEqual(whoseTurn([at("code"), at("waiting")]), [1]);
  assert.deepEqual(whoseTurn([at("code"), at("code")]), [0]);
});

test("who has declined no longer sits here, and a completion code keeps its place", () => {
  const declined = at("code");
  const done = { ...at("code"), step: { key: "code", kind: "code", code: "K7QX4WPL2M" } };
  assert.deepEqual(stillHere([at("waiting"), declined]), [0]);
  assert.deepEqual(stillHere([declined, at("consent")]), [1]);
  assert.deepEqual(stillHere([done, at("waiting")]), [0, 1]);
  assert.deepEqual(stillHere([declined]), []);
});

/** @param {number} seat @param {string} token */
const inRoom = (seat, token, id = "r1") => ({
  key: "k",
  kind: "round",
  room: { id, token, seat, path: `/play/${id}` },
});

test("the seats of a round are taken in their order once all are known", () => {
  const [id, path] = ["r1", "/play/r1"];
  assert.deepEqual(seatsToTake([inRoom(1, "red")]), { id, path, tokens: [null, "red"], people: [-1, 0] });
  assert.deepEqual(seatsToTake([inRoom(1, "red"), inRoom(0, "blue")]), {
    id,
    path,
    tokens: ["blue", "red"],
    people: [1, 0],
  });
  assert.equal(seatsToTake([inRoom(0, "blue"), { key: "k", kind: "round", room: null }]), null);
  assert.equal(seatsToTake([inRoom(0, "blue"), inRoom(1, "red", "r2")]), null);
});
