import assert from "node:assert/strict";
import { test } from "node:test";

import { changedPlaces } from "../../view/painter.js";

const box = (/** @type {number} */ left, /** @type {number} */ top) => ({
  left,
  top,
  right: left + 10,
  bottom: top + 10,
});

test("what stands still is not drawn again", () => {
  const bodies = [
    { key: "a", box: box(0, 0) },
    { key: "b", box: box(50, 50) },
  ];
  assert.deepEqual(changedPlaces(bodies, bodies, 100), []);
});

test("a body that moved is drawn where it was and where it is, within the canvas", () => {
  const before = [
    { key: "a", box: box(-4, 0) },
    { key: "b", box: box(50, 50) },
  ];
  const now = [
    { key: "a2", box: box(2, 95) },
    { key: "b", box: box(50, 50) },
  ];
  assert.deepEqual(changedPlaces(before, now, 100), [
    { left: 0, top: 0, right: 6, bottom: 10 },
    { left: 2, top: 95, right: 12, bottom: 100 },
  ]);
});

test("places that overlap are one place", () => {
  const before = [
    { key: "a", box: box(0, 0) },
    { key: "b", box: box(14, 0) },
  ];
  const now = [
    { key: "a2", box: box(6, 2) },
    { key: "b2", box: box(60, 60) },
  ];
  assert.deepEqual(changedPlaces(before, now, 100), [
    { left: 0, top: 0, right: 24, bottom: 12 },
    { left: 60, top: 60, right: 70, bottom: 70 },
  ]);
});

test("a body outside of the canvas needs nothing", () => {
  const at = (/** @type {string} */ key) => [{ key, box: box(200, 0) }];
  assert.deepEqual(changedPlaces(at("a"), at("b"), 100), []);
});
