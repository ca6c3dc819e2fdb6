import assert from "node:assert/strict";
import { test } from "node:test";

import { expectedRobots, movedItems, wayOf } from "../../play/decision_trace.js";

test("a candidate's way goes a step per tick where its heading points, backward when the distance is negative", () => {
  const way = wayOf(
    [
      [1, 1, 0],
      [0.5, 0, 1],
      [-1, 1, 0],
    ],
    [0, 0, 0],
  );
  assert.deepEqual(
    way.map(([x, y]) => [Number(x.toFixed(3)), Number(y.toFixed(3))]),
    [
      [0, 0],
      [0, 0.06],
      [-0.03, 0.06],
      [-0.03, 0],
    ],
  );
});

test("only items that the chosen candidate moves are shown", () => {
  const view = {
    poses: /** @type {[number, number, number][]} */ ([
      [0, 0, 0],
      [0, 0, 0],
      [0.5, 0.5, 0],
      [0, 0.5, 0],
    ]),
    held: [-1, -1],
    delivered: [false, false],
  };
  const decision = {
    seat: 0,
    tick: 3,
    chosen: 1,
    scores: [0, 1],
    candidates: [],
    items: /** @type {[number, number][][]} */ ([
      [
        [0, 0],
        [0, 0],
      ],
      [
        [0.5, 0.51],
        [0.1, 0.5],
      ],
    ]),
  };
  assert.deepEqual(movedItems(decision, view), [{ item: 1, place: [0.1, 0.5] }]);
});

test("the robots are shown where the chosen candidate will probably bring them, per prediction of the partner", () => {
  const decision = { seat: 0, tick: 3, chosen: 1, scores: [0, 1], candidates: [], items: [] };
  const rollout = (/** @type {number} */ x) =>
    /** @type {[[number, number], [number, number]][]} */ ([
      [
        [x, 0],
        [0, x],
      ],
    ]);
  const pairs = /** @type {[number, number][]} */ ([
    [0, 0],
    [0, 1],
    [1, 0],
    [1, 1],
  ]);
  assert.deepEqual(expectedRobots({ ...decision, pairs, robots: [1, 2, 3, 4].map(rollout) }), [rollout(3), rollout(4)]);
  assert.deepEqual(expectedRobots(decision), []); // an agent, or a recording, that does not tell
});
