import assert from "node:assert/strict";
import { test } from "node:test";

import { badgePlaces, ranksOf } from "../../view/candidates.js";

/** @typedef {import("../../view/candidates.js").Point} Point */

test("the highest score has rank 1, and no two candidates have the same", () => {
  assert.deepEqual(ranksOf([0.1, 0.4, 0.4, -2]), [3, 1, 2, 4]);
});

test("ranks stand neither on one another nor on a robot, also where all paths end at one place or on the robot", () => {
  const robots = /** @type {Point[]} */ ([
    [0, 0],
    [0.3, 0],
  ]);
  for (const end of /** @type {Point[]} */ ([
    [0, 0.1],
    [1.19, 1.19],
    [0.15, 0],
  ])) {
    const ways = Array.from({ length: 8 }, () => /** @type {Point[]} */ ([[0, 0], end]));
    const places = badgePlaces(ways, ranksOf([8, 7, 6, 5, 4, 3, 2, 1]), robots);
    for (const [index, [x, y]] of places.entries()) {
      for (const [a, b] of robots) assert.ok(Math.hypot(x - a, y - b) > 0.17, `${end}: ${index} on a robot`);
      for (const [a, b] of places.slice(index + 1)) assert.ok(Math.hypot(x - a, y - b) > 0.1, `${end}: ${index}`);
      assert.ok(Math.max(Math.abs(x), Math.abs(y)) <= 1.15);
    }
  }
});
