import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { Announcer } from "../../play/announcer.js";
import { speak } from "../text/support.js";

speak("en");

class FakeElement {
  textContent = "";
}
let region = new FakeElement();

beforeEach(() => {
  region = new FakeElement();
  Object.assign(globalThis, { HTMLElement: FakeElement, document: { getElementById: () => region } });
});

/** What is said while these ticks of a round of 60 s are shown, two seconds apart. @param {number[]} ticks */
function heard(...ticks) {
  const announcer = new Announcer();
  const game = /** @type {any} */ ({ phase: "playing", round: { limit_ticks: 600 }, room: null, own: [0] });
  return ticks.map((tick, index) => {
    region.textContent = "";
    announcer.update(game, /** @type {any} */ ({ view: { delivered: [] }, stalled: false, tick }), 2000 * index);
    return region.textContent;
  });
}

test("half of the time and the last ten seconds are said as they pass", () => {
  assert.deepEqual(heard(0, 299, 301, 499, 501), ["Go.", "", "Half of the time is over.", "", "Ten seconds left."]);
});

test("a page that is reloaded or comes late says nothing of what passed before", () => {
  assert.deepEqual(heard(550, 551), ["Go.", ""]);
  assert.deepEqual(heard(310, 311, 500), ["Go.", "", "Ten seconds left."]);
});

test("a game that is over before its round is said, with why", () => {
  const announcer = new Announcer();
  const seats = [{ kind: "human" }, { kind: "human" }];
  const left = { seats, reason: "Blue left.", reason_code: "left", reason_values: { players: ["blue"] } };
  const game = /** @type {any} */ ({ phase: "lobby", round: null, room: { ...left, phase: "lobby" }, own: [1] });
  const scene = /** @type {any} */ ({ view: { delivered: [] }, stalled: false, tick: 0 });
  announcer.update(game, scene, 0);
  game.phase = game.room.phase = "series_over";
  announcer.update({ ...game, overBeforeRound: true }, scene, 2000);
  assert.equal(region.textContent, "Blue left the game.");
});
