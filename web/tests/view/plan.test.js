import assert from "node:assert/strict";
import { test } from "node:test";

import { planSentence } from "../../view/decision_words.js";
import { planOf } from "../../view/plan.js";
import { speak } from "../text/support.js";

/** @typedef {import("../../view/candidates.js").Decision} Decision */
/** @typedef {import("../../view/render.js").GameMap} GameMap */
/** @typedef {import("../../view/render.js").View} View */

const map = /** @type {GameMap} */ (
  /** @type {unknown} */ ({
    goals: [{ x0: -0.2, y0: 0.8, x1: 0.2, y1: 1.2 }],
    items: [{ size: "large" }, { size: "small" }],
  })
);
/** Blue below a large item, red to its left; a small item to the right of blue. @param {Partial<View>} [more] */
const view = (more) =>
  /** @type {View} */ ({
    poses: [
      [0, -0.8, 0],
      [-0.8, 0, 0],
      [0, 0, 0],
      [0.8, -0.8, 0],
    ],
    held: [-1, -1],
    delivered: [false, false],
    ...more,
  });
/** @param {Partial<Decision>} more @returns {Decision} */
const decision = (more) => ({
  seat: 0,
  tick: 1,
  chosen: 0,
  scores: [1],
  ways: [
    [
      [0, -0.8],
      [0, -0.4],
    ],
  ],
  moves: [],
  own: [],
  partner: [],
  guesses: [],
  ...more,
});

test("who drives to an item wants to fetch it, and expects the partner where most predictions bring it", () => {
  assert.deepEqual(planOf(map, view(), decision({})), { kind: "fetch", item: 0, hopes: false });
  const comes = /** @type {[number, number][]} */ ([[-0.4, 0]]);
  const stays = /** @type {[number, number][]} */ ([[-0.8, 0.1]]);
  assert.equal(planOf(map, view(), decision({ partner: [comes, comes, stays] }))?.hopes, true);
  assert.equal(planOf(map, view(), decision({ partner: [comes, stays] }))?.hopes, false);
  assert.equal(
    planOf(
      map,
      view(),
      decision({
        ways: [
          [
            [0, -0.8],
            [0.5, -0.8],
          ],
        ],
      }),
    )?.item,
    1,
  );
});

test("what is held and comes nearer to a goal is delivered, with the partner where it holds the same", () => {
  const moves = [{ item: 0, place: /** @type {[number, number]} */ ([0, 0.3]) }];
  assert.equal(planOf(map, view({ held: [0, -1] }), decision({ moves }))?.kind, "deliver");
  assert.equal(planOf(map, view({ held: [0, 0] }), decision({ moves }))?.kind, "together");
});

test("nothing is said where it cannot be told", () => {
  const away = [{ item: 0, place: /** @type {[number, number]} */ ([0, -0.3]) }];
  assert.equal(planOf(map, view({ held: [0, 0] }), decision({ moves: away })), null, "away from the goal");
  assert.equal(planOf(map, view({ held: [0, 0] }), decision({})), null, "not moved");
  assert.equal(
    planOf(
      map,
      view(),
      decision({
        ways: [
          [
            [0, -0.8],
            [0, -0.78],
          ],
        ],
      }),
    ),
    null,
    "at rest",
  );
  assert.equal(
    planOf(
      map,
      view(),
      decision({
        ways: [
          [
            [0, -0.8],
            [-0.4, -0.8],
          ],
        ],
      }),
    ),
    null,
    "towards no item",
  );
  assert.equal(planOf(map, view({ delivered: [true, false] }), decision({})), null, "delivered");
  assert.equal(planOf(map, view(), decision({ chosen: -1 })), null);
  const between = view({
    poses: [
      [0, -0.8, 0],
      [-0.8, 0, 0],
      [-0.05, 0, 0],
      [0.05, 0, 0],
    ],
  });
  assert.equal(planOf(map, between, decision({})), null, "two items in the same direction");
});

test("the plan is a sentence in the language of the reader", () => {
  const plan = /** @type {const} */ ({ kind: "fetch", item: 0, hopes: true });
  speak("en");
  assert.equal(planSentence(plan, 0, map), "Blue wants to fetch the large item and expects Red to come too.");
  speak("de");
  assert.match(planSentence(plan, 1, map), /^Rot will den großen Gegenstand holen und rechnet damit, dass Blau /);
  assert.match(planSentence({ ...plan, hopes: false }, 1, map), /holen\.$/);
  speak("en");
});
