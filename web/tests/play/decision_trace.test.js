import assert from "node:assert/strict";
import { mock, test } from "node:test";

import { DecisionPanel, expectedRobots, movedItems, wayOf } from "../../play/decision_trace.js";

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

test("whether an agent weighs is asked until the room is gone, and not while nobody sees the page", async () => {
  mock.timers.enable({ apis: ["setTimeout"] });
  const page = {
    hidden: false,
    createElement: () => ({ setAttribute: () => {}, addEventListener: () => {}, append: () => {} }),
  };
  let asked = 0;
  let status = 200;
  Object.assign(globalThis, {
    document: page,
    fetch: async () => Response.json({ weighs: false }, { status: (asked += 1) && status }),
  });
  const wait = async () => {
    mock.timers.tick(2000);
    await new Promise((done) => setImmediate(done));
  };
  await new DecisionPanel(/** @type {any} */ ({}), "/api/rooms/abc").offerWhenWeighing();
  await wait();
  assert.equal(asked, 2);
  page.hidden = true;
  await wait();
  await wait();
  assert.equal(asked, 2);
  page.hidden = false;
  status = 404;
  await wait();
  assert.equal(asked, 3);
  await wait();
  await wait();
  assert.equal(asked, 3);
  mock.timers.reset();
});
