import assert from "node:assert/strict";
import { test } from "node:test";

import { arenaPoint, itemAhead, itemAt, OWN_PLACE } from "../../view/ping_target.js";

/** @typedef {import("../../view/render.js").GameMap} GameMap */
/** @typedef {import("../../view/render.js").View} View */

const map = /** @type {GameMap} */ (
  /** @type {unknown} */ ({ items: [{ scale: 0.1 }, { scale: 0.2 }, { scale: 0.1 }] })
);

/** Blue at the origin looks up, items above, further above and to the right. @param {Partial<View>} [more] */
function view(more) {
  return /** @type {View} */ ({
    poses: [
      [0, 0, 0],
      [1, 1, 0],
      [0, 0.4, 0],
      [0, 0.8, 0],
      [0.4, 0, 0],
    ],
    held: [-1, -1],
    delivered: [false, false, false],
    ...more,
  });
}

test("the key asks for help with what is held, else with the nearest item in front, else at the own place", () => {
  assert.equal(itemAhead(map, view(), 0), 0);
  assert.equal(itemAhead(map, view({ delivered: [true, false, false] }), 0), 1);
  assert.equal(itemAhead(map, view({ held: [2, -1] }), 0), 2);
  const { poses } = view();
  const turned = (/** @type {number} */ angle) => view({ poses: [[0, 0, angle], ...poses.slice(1)] });
  assert.equal(itemAhead(map, turned(-Math.PI / 2), 0), 2, "an angle of minus 90 degrees looks right");
  assert.equal(itemAhead(map, turned(Math.PI), 0), OWN_PLACE, "nothing is behind");
  assert.equal(itemAhead(map, view(), 1), OWN_PLACE, "too far away");
});

test("a tap points at the item under the finger or, on the own robot, at the own place, and nowhere else", () => {
  assert.equal(itemAt(map, view(), 0, { x: 0.05, y: 0.78 }), 1);
  assert.equal(itemAt(map, view(), 0, { x: 0.55, y: 0.05 }), 2);
  assert.equal(itemAt(map, view(), 1, { x: 1.1, y: 0.95 }), OWN_PLACE);
  assert.equal(itemAt(map, view(), 0, { x: -0.8, y: -0.8 }), null);
});

test("a place in the window becomes a place in the arena, whose y points up", () => {
  const box = /** @type {DOMRect} */ ({ left: 100, top: 50, width: 480, height: 480 });
  assert.deepEqual(arenaPoint(box, { x: 340, y: 290 }), { x: 0, y: 0 });
  assert.deepEqual(arenaPoint(box, { x: 580, y: 50 }), { x: 1.2, y: 1.2 });
});
