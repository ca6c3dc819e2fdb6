// Bundles for tests: the golden one in which nothing happens, changed as a test needs it.

import { readFileSync } from "node:fs";

import { decodeBundle } from "../messages.js";

/** @typedef {import("../messages.js").Bundle} Bundle */

/** @type {{name: string, hex: string}[]} */
const golden = JSON.parse(readFileSync(new URL("../../tests/server/golden_frames.json", import.meta.url), "utf8"));
const AT_REST = golden.find(({ name }) => name === "bundle at rest");

/**
 * A bundle of three bodies whose first robot is at `blueX` in each pose, with one item that is not delivered.
 * @param {(pose: number) => number} blueX
 * @param {Partial<Bundle>} fields
 * @returns {Bundle}
 */
export function makeBundle(blueX, fields) {
  const poses = new Float64Array(5 * 3 * 3);
  for (let pose = 0; pose < 5; pose += 1) poses[9 * pose] = blueX(pose);
  const nothing = decodeBundle(Uint8Array.from(Buffer.from(AT_REST?.hex ?? "", "hex")).buffer);
  return { ...nothing, epoch: 1, delivered: [false], bodies: 3, poses, ...fields };
}
