// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { TriedControls } from "../../../study/input_check/tried_controls.js";

/** @param {Partial<import("../../../input/seats.js").SeatReading>} reading */
const pressed = (reading) => ({
  stick: { x: 0, y: 0 },
  backward: false,
  grabs: 0,
  pings: 0,
  device: /** @type {const} */ ("keyboard"),
  ...reading,
});

test("controls are tried when each direction, grab and backward were pressed once; a stick at rest is nothing", () => {
  const tried = new TriedControls(false);
  assert.equal(tried.add(pressed({ stick: { x: 0.2, y: -0.2 } })), false);
  assert.equal(tried.add(pressed({ stick: { x: 0.7, y: 0.7 } })), true);
  assert.deepEqual(tried.todo, ["left", "down", "grab", "backward"]);
  tried.add(pressed({ stick: { x: -1, y: 0 } }));
  tried.add(pressed({ stick: { x: 0, y: -1 }, grabs: 1 }));
  assert.deepEqual(tried.todo, ["backward"]);
  tried.add(pressed({ backward: true }));
  assert.deepEqual(tried.todo, []);
});

test("where a gamepad is required, keys do not count", () => {
  const tried = new TriedControls(true);
  assert.equal(tried.add(pressed({ grabs: 1 })), false);
  assert.equal(tried.add(pressed({ grabs: 1, device: "gamepad" })), true);
});
