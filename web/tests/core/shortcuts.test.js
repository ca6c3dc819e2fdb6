// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { actionFor } from "../../core/shortcuts.js";

const ACTIONS = { r: "turn", w: "wall", z: "undo", ",": "before", 1: "confirm", ArrowLeft: "left", "+": "faster" };

/** @param {string} key @param {string} code @param {boolean} [shiftKey] */
const meant = (key, code, shiftKey = false) => actionFor(ACTIONS, { key, code, shiftKey });

test("what is printed on the key counts, on every Latin keyboard", () => {
  assert.equal(meant("w", "KeyW"), "wall");
  assert.equal(meant("w", "KeyZ"), "wall", "French");
  assert.equal(meant("z", "KeyY"), "undo", "German");
  assert.equal(meant("y", "KeyZ"), undefined, "German: the place says nothing");
  assert.equal(meant(",", "KeyM"), "before", "French");
  assert.equal(meant("ArrowLeft", "ArrowLeft"), "left");
  assert.equal(meant("Dead", "Quote"), undefined);
  assert.equal(meant("constructor", ""), undefined);
});

test("Caps Lock and Shift change nothing", () => {
  assert.equal(meant("W", "KeyW"), "wall");
  assert.equal(meant("R", "KeyR", true), "turn");
});

test("where the key has no Latin letter its place counts", () => {
  assert.equal(meant("ц", "KeyW"), "wall", "Russian");
  assert.equal(meant("б", "Comma"), "before", "Russian");
  assert.equal(meant("&", "Digit1"), "confirm", "French");
  assert.equal(meant("!", "Digit1", true), undefined, "the other sign of a US key");
  assert.equal(meant("", ""), undefined);
});
