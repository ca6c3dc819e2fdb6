// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { decisionsAt, pingsAt, recordedDecision, trail } from "../../replay/overlay.js";

/** @param {number} seat @param {number} tick @param {number[]} scores */
const decision = (seat, tick, scores = [0.5]) => ({
  seat,
  tick,
  chosen: 0,
  scores,
  ways: [],
  moves: [],
  robots: [],
  guesses: [],
});
const THOUGHTS = [decision(1, 1), decision(0, 5), decision(1, 9), decision(1, 17)];

test("the newest decision of each seat is shown, the first one already at the start", () => {
  const ticks = (/** @type {number} */ tick) => decisionsAt(THOUGHTS, tick).map(({ seat, tick: made }) => [seat, made]);
  assert.deepEqual(ticks(0), [[1, 1]]);
  assert.deepEqual(ticks(8), [
    [0, 5],
    [1, 1],
  ]);
  assert.deepEqual(ticks(9), [
    [0, 5],
    [1, 9],
  ]);
});

test("a decision that nothing followed is over after a second and a half", () => {
  assert.deepEqual(
    decisionsAt(THOUGHTS, 21).map(({ seat }) => seat),
    [1],
  );
  assert.deepEqual(decisionsAt(THOUGHTS, 33), []);
});

test("items that were to be moved are found by where they were", () => {
  const view = /** @type {import("../../view/render.js").View} */ (
    /** @type {unknown} */ ({
      poses: [
        [0, 0, 0],
        [1, 0, 0],
        [0.5, 0.5, 0],
        [0.5, 0.9, 0],
      ],
    })
  );
  /** @type {[[number, number], [number, number]][]} */
  const moves = [
    [
      [0.5001, 0.9],
      [0.2, 0.2],
    ],
    [
      [-1, -1],
      [0, 0],
    ],
  ];
  const told = recordedDecision(
    {
      ...decision(1, 3),
      robots: [
        [
          [
            [0, 0],
            [1, 1],
          ],
        ],
      ],
      moves,
    },
    view,
  );
  assert.deepEqual(told.moves, [{ item: 1, place: [0.2, 0.2] }]);
  assert.deepEqual([told.own, told.partner], [[[[1, 1]]], [[[0, 0]]]]);
});

test("a trail begins where the robot does not stand on it", () => {
  const way = /** @type {[number, number][]} */ ([
    [0, 0],
    [0, -0.06],
    [0, -0.13],
    [0, -0.2],
  ]);
  assert.deepEqual(trail(way), [{ from: [0, -0.13], to: [0, -0.2], age: 3 }]);
  assert.deepEqual(trail([[0.3, 0.3]]), []);
});

test("a ping is shown for two seconds after it was said, at the place where the robot was then", () => {
  const events = [
    { tick: 11, kind: "ping", seat: 1, item: -1, detail: "" },
    { tick: 12, kind: "grab", seat: 1, item: 0, detail: "" },
    { tick: 21, kind: "ping", seat: 0, item: 2, detail: "" },
  ];
  const replay = /** @type {import("../../replay/data.js").Replay} */ (
    /** @type {unknown} */ ({
      summary: { events },
      viewAt: (/** @type {number} */ ms) => ({
        poses: [
          [0, ms / 1000, 0],
          [1, ms / 1000, 0],
        ],
      }),
    })
  );
  const seats = (/** @type {number} */ ms) => pingsAt(replay, ms).map(({ seat, item }) => [seat, item]);
  assert.deepEqual(
    [seats(999), seats(1000), seats(2500), seats(3000)],
    [
      [],
      [[1, -1]],
      [
        [1, -1],
        [0, 2],
      ],
      [[0, 2]],
    ],
  );
  assert.deepEqual(pingsAt(replay, 1500), [{ seat: 1, item: -1, x: 1, y: 1 }]);
});
