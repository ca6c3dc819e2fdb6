import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import * as messages from "../messages.js";

/** @typedef {"Beat" | "Ping" | "Pong" | "Input" | "Bundle"} FrameName */
/** @typedef {{name: string, frame: FrameName, hex: string, value: Record<string, unknown>}} Golden */

/** @type {Golden[]} the same bytes that the server's own test reads */
const golden = JSON.parse(readFileSync(new URL("../../tests/server/golden_frames.json", import.meta.url), "utf8"));

/** @param {string} hex @returns {ArrayBuffer} */
const bytes = (hex) => Uint8Array.from(Buffer.from(hex, "hex")).buffer;

/** @param {ArrayBuffer} buffer */
const hexOf = (buffer) => Buffer.from(buffer).toString("hex");

const DECODERS = {
  Beat: messages.decodeBeat,
  Ping: messages.decodePing,
  Pong: messages.decodePong,
  Input: messages.decodeInput,
  Bundle: messages.decodeBundle,
};
const ENCODERS = {
  Beat: messages.encodeBeat,
  Ping: messages.encodePing,
  Pong: messages.encodePong,
  Input: messages.encodeInput,
};

/** Compares as the wire rounds. @param {unknown} actual @param {unknown} expected @param {string} path */
function same(actual, expected, path) {
  if (typeof expected === "number") {
    assert.ok(Math.abs(Number(actual) - expected) < 1e-9, `${path}: ${actual} is not ${expected}`);
  } else if (typeof expected === "object" && expected !== null) {
    const entries = Object.entries(expected);
    assert.equal(Object.keys(/** @type {object} */ (actual)).length, entries.length, path);
    for (const [key, value] of entries) same(/** @type {any} */ (actual)[key], value, `${path}.${key}`);
  } else {
    assert.equal(actual, expected, path);
  }
}

for (const { name, frame, hex, value } of golden) {
  test(`the golden frame "${name}" reads the same here as on the server`, () => {
    same(DECODERS[frame](bytes(hex)), flat(value), name);
  });
  if (frame !== "Bundle") {
    test(`the golden frame "${name}" has the same bytes when written here`, () => {
      assert.equal(hexOf(ENCODERS[frame](/** @type {any} */ (value))), hex);
    });
  }
}

/** The file may nest poses by pose and body; here they are one array. @param {Record<string, unknown>} value */
function flat(value) {
  return Array.isArray(value.poses) ? { ...value, poses: value.poses.flat(2) } : value;
}

test("a frame that was cut is refused", () => {
  for (const { frame, hex } of golden) {
    assert.throws(() => DECODERS[frame](bytes(hex.slice(0, -2))), RangeError);
    assert.throws(() => DECODERS[frame](new ArrayBuffer(0)), RangeError);
  }
});
