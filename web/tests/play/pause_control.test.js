// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { PauseControl } from "../../play/pause_control.js";

/** @param {string} phase @param {number[]} own */
function page(phase, own = [1]) {
  /** @type {unknown[]} */
  const done = [];
  const game = { phase, own };
  const panels = { askStop: () => done.push("ask") };
  const pauses = new PauseControl({
    game: /** @type {import("../../play/game.js").Game} */ (/** @type {unknown} */ (game)),
    panels: /** @type {import("../../play/panels.js").Panels} */ (/** @type {unknown} */ (panels)),
    pause: (seat) => done.push(["pause", seat]),
    ready: (seat) => done.push(["ready", seat]),
    dialogIsOpen: () => false,
  });
  return { pauses, game, done };
}

test("a round is paused by a seat of this page, and goes on by it", () => {
  const { pauses, game, done } = page("playing");
  pauses.toggle(true);
  game.phase = "paused";
  pauses.toggle(true, 0);
  game.phase = "round_over";
  pauses.toggle(true);
  assert.deepEqual(done, [
    ["pause", 1],
    ["ready", 0],
  ]);
});

test("whoever only watches pauses nothing", () => {
  const { pauses, done } = page("playing", []);
  pauses.toggle(true);
  assert.deepEqual(done, []);
});

test("the button pauses a round, and asks whether to stop where none is played", () => {
  for (const [phase, wanted] of /** @type {const} */ ([
    ["playing", ["pause", 1]],
    ["lobby", "ask"],
  ])) {
    const { pauses, done } = page(phase);
    pauses.pauseOrStop();
    assert.deepEqual(done, [wanted]);
  }
});

test("who asked for a pause that is refused is asked whether to stop, and who opened a dialog is not", () => {
  for (const asked of [true, false]) {
    const { pauses, done } = page("playing");
    pauses.toggle(asked);
    pauses.refused();
    assert.deepEqual(done.slice(1), asked ? ["ask"] : []);
  }
});
