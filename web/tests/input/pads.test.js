// Whose gamepad is whose: over reloads, reconnections, rounds in which people change robots, and unplugging.
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { Gamepads } from "../../input/gamepad.js";
import { DEFAULTS } from "../../input/mapping.js";
import { PadMemory } from "../../input/pad_memory.js";
import { LocalSeats } from "../../input/seats.js";
import { CENTRED } from "../../input/stick.js";
import { LostPads } from "../../input/lost_pads.js";
import { speak } from "../text/support.js";

speak("en");

const UNTOUCHED = { stick: CENTRED, backward: false, grabs: 0, pings: 0 };
/** @type {Map<string, string>} */
let storage = new Map();
beforeEach(() => {
  storage = new Map();
});

/** @param {number} index @param {object} [more] @returns {Gamepad} */
function pad(index, more = {}) {
  const buttons = Array.from({ length: 17 }, () => ({ pressed: false, touched: false, value: 0 }));
  const state = { index, id: "the same", connected: true, mapping: "standard", axes: [0, 0, 0, 0], buttons, ...more };
  return /** @type {Gamepad} */ (/** @type {unknown} */ (state));
}
/** @param {number} index */
const driven = (index) => pad(index, { axes: [1, 0, 0, 0] });

/** @param {readonly number[]} [people] who is blue and who is red, as a page of a study knows them */
function twoSeats(people) {
  /** @type {{pads: (Gamepad | null)[]}} */
  const plugged = { pads: [] };
  const store = {
    getItem: (/** @type {string} */ key) => storage.get(key) ?? null,
    setItem: (/** @type {string} */ key, /** @type {string} */ text) => void storage.set(key, text),
  };
  const keyboard = { read: () => UNTOUCHED, isUsed: () => false };
  const touch = { read: () => UNTOUCHED, used: false };
  const devices = { keyboard, touch, gamepads: new Gamepads(() => plugged.pads) };
  const seats = new LocalSeats(devices, "keyboard", new PadMemory("study", people, () => store));
  seats.hold([0, 1]);
  /** @param {(Gamepad | null)[]} pads @returns {(number | undefined)[]} the pads of blue and red */
  const read = (...pads) => {
    plugged.pads = pads;
    seats.read(DEFAULTS);
    return seats.cards().map((card) => card.pad?.index);
  };
  return { seats, read };
}

test("a new connection in a round leaves the gamepads where they are", () => {
  const { seats, read } = twoSeats();
  read(pad(0), driven(1));
  assert.deepEqual(read(driven(0), pad(1)), [1, 0]);
  seats.hold([0, 1]);
  assert.deepEqual(read(driven(0), driven(1)), [1, 0]);
});

test("in the next round everybody has their gamepad, whoever moves first, whichever robot they have", () => {
  const check = twoSeats();
  check.read(driven(0), pad(1));
  check.read(pad(0), driven(1));
  assert.deepEqual(twoSeats([0, 1]).read(pad(0), driven(1)), [undefined, 1]);
  assert.deepEqual(twoSeats([1, 0]).read(pad(0), driven(1)), [1, undefined]);
});

test("people who swap sides keep their gamepads so", () => {
  const { seats, read } = twoSeats();
  read(driven(0), driven(1));
  seats.swap();
  assert.deepEqual(read(null, pad(1)), [1, undefined], "red's is gone");
  assert.deepEqual(seats.padsLost, [1]);
  assert.deepEqual(twoSeats().read(driven(0), pad(1)), [undefined, 0]);
});

test("who has the only gamepad keeps it on the other side, also after it was unplugged and after a reload", () => {
  const { seats, read } = twoSeats();
  read(driven(0));
  seats.swap();
  assert.deepEqual(read(pad(0)), [undefined, 0]);
  read();
  assert.deepEqual(seats.padsLost, [1]);
  assert.deepEqual(read(driven(0)), [undefined, 0]);
  assert.deepEqual(twoSeats().read(driven(0)), [undefined, 0]);
});

test("two gamepads that are gone come back to their seats; a strange one replaces the one that is missing", () => {
  const { seats, read } = twoSeats();
  read(driven(0), driven(1));
  assert.deepEqual(read(), [undefined, undefined]);
  assert.deepEqual(seats.padsLost, [0, 1]);
  assert.deepEqual(read(null, driven(1)), [undefined, 1]);
  assert.deepEqual(twoSeats().read(pad(0), null, driven(2)), [undefined, 2]);
  assert.deepEqual(twoSeats().read(driven(3)), [3, undefined]);
});

test("two gamepads of different models that wake up in another order go back to their people", () => {
  const { seats, read } = twoSeats();
  /** @param {number} index @param {string} id */
  const used = (index, id) => ({ ...driven(index), id });
  read(used(0, "Xbox"), used(1, "PS"));
  read();
  assert.deepEqual(read(used(0, "PS")), [undefined, 0]);
  assert.deepEqual(seats.padsOwned, [1]);
  assert.deepEqual(read({ ...pad(0), id: "PS" }, used(1, "Xbox")), [1, 0]);
  assert.deepEqual(twoSeats().read(used(0, "PS"), used(1, "Xbox")), [1, 0], "also after a reload");
  const left = twoSeats(); // red's is not there yet, and blue's is not in use
  assert.deepEqual(left.read(null, { ...pad(1), id: "Xbox" }, used(2, "Xbox")), [undefined, 2], "not blue's twin");
});

test("a strange gamepad goes to nobody whose own is back under another index", () => {
  const { read } = twoSeats();
  read({ ...driven(0), id: "Xbox" }, { ...driven(1), id: "PS" });
  read();
  assert.deepEqual(read(null, { ...pad(1), id: "Xbox" }, { ...driven(2), id: "new" }), [undefined, 2]);
});

test("what another page left in the storage does no harm", () => {
  for (const text of ["{", "7", "[3, null]", '["pad"]']) {
    storage.set("movingout.pads.study", text);
    assert.deepEqual(twoSeats().read(driven(0), driven(1)), [0, 1]);
  }
});

test("the d-pad of a gamepad that the browser does not know is a stick too", () => {
  /** @param {number[]} axes */
  const stickOf = (axes, mapping = "") => {
    const [{ stick }] = new Gamepads(() => [pad(0, { axes, mapping })]).read(DEFAULTS);
    return [stick.x, stick.y].map((value) => Math.round(value * 100) / 100 + 0);
  };
  const windows = (/** @type {number} */ hat) => stickOf([0, 0, 0, 0, 0, 0, 0, 0, 0, hat]);
  assert.deepEqual(
    [-1, -0.71429, -0.42857, 0.14286, 0.71429, 1].map(windows),
    [[0, 1], [0.71, 0.71], [1, 0], [0, -1], [-1, 0], [-0.71, 0.71]],
  ); // prettier-ignore
  for (const rest of [1.28571, 3.28571, 0]) assert.deepEqual(windows(rest), [0, 0]);
  assert.deepEqual(stickOf([0, 0, -1, 0, 0, -1, -1, 0]), [-1, 0]);
  assert.deepEqual(stickOf([0, 0, -1, 0, 0, -1, 0, 1]), [0, -1]);
  assert.deepEqual(stickOf([0, 0, 0, 0, 0, 0, 1, 1], "standard"), [0, 0]);
});

test("a round pauses for whose gamepad is gone, once, and not for one that went between rounds", () => {
  const lost = new LostPads();
  assert.equal(lost.update({ padsLost: [1], padsPresent: 1, padsOwned: [0] }, "lobby"), null);
  assert.equal(lost.update({ padsLost: [], padsPresent: 1, padsOwned: [0] }, "playing"), null);
  assert.equal(lost.hint([0, 1]), "");
  assert.equal(lost.update({ padsLost: [1], padsPresent: 1, padsOwned: [0] }, "playing"), 1);
  assert.equal(lost.update({ padsLost: [], padsPresent: 1, padsOwned: [0] }, "playing"), null);
  assert.match(lost.hint([0, 1]), /^Red's gamepad is no longer connected\./);
  assert.match(lost.hint([1]), /^Your gamepad is no longer connected\./);
  lost.update({ padsLost: [], padsPresent: 2, padsOwned: [0, 1] }, "paused");
  assert.equal(lost.hint([0, 1]), "Red's gamepad is connected again.");
  lost.forget();
  assert.equal(lost.hint([0, 1]), "");
});

test("a pause button pauses for the seat that its gamepad drives", () => {
  const { seats, read } = twoSeats();
  read(driven(0), driven(1));
  const buttons = pad(0).buttons.map((button, index) => ({ ...button, pressed: index === DEFAULTS.buttons.pause }));
  read(pad(0), pad(1, { buttons }));
  assert.deepEqual(seats.pauses, [1]);
  read(pad(0), pad(1, { buttons }));
  assert.deepEqual(seats.pauses, [], "held, not pressed again");
  seats.hold([1]);
  read(pad(0, { buttons }), pad(1));
  assert.deepEqual(seats.pauses, [1], "every gamepad of one person is theirs");
});

/** Two people with a gamepad each, in a round. */
function twoPads() {
  const { seats, read } = twoSeats();
  const lost = new LostPads();
  read(driven(0), driven(1));
  /** For whom the round pauses. @param {string} phase @param {(Gamepad | null)[]} pads */
  const pausesFor = (phase, ...pads) => {
    read(...pads);
    return lost.update(seats, phase);
  };
  /** What is said when these are plugged in. @param {string} phase @param {(Gamepad | null)[]} pads */
  const hint = (phase, ...pads) => {
    pausesFor(phase, ...pads);
    return lost.hint([0, 1]);
  };
  return { lost, hint, pausesFor };
}

test("when the second gamepad is lost in the pause for the first, the pause says whose is missing", () => {
  const { hint } = twoPads();
  assert.match(hint("playing", pad(0)), /^Red's gamepad is no longer connected\./);
  assert.match(hint("paused"), /^Neither gamepad is connected any more\./);
  assert.match(hint("paused", null, pad(1)), /^Blue's gamepad is no longer connected\./);
  assert.match(hint("paused", pad(0)), /^Red's gamepad is no longer connected\./);
  assert.equal(hint("paused", pad(0), pad(1)), "Both gamepads are connected again.");
});

test("when the first is back before the second is lost, the second alone is missing", () => {
  const { lost, hint } = twoPads();
  hint("playing", pad(0));
  assert.equal(hint("paused", pad(0), pad(1)), "Red's gamepad is connected again.");
  assert.match(hint("paused", null, pad(1)), /^Blue's gamepad is no longer connected\./);
  lost.forget();
  assert.equal(hint("playing", null, pad(1)), "", "play went on without it");
});

test("a round pauses for who has lost a gamepad, not for who had lost one in the countdown and has it back", () => {
  const { hint, pausesFor } = twoPads();
  assert.equal(pausesFor("countdown", pad(0)), null);
  assert.equal(pausesFor("countdown", pad(0), driven(1)), null);
  assert.equal(pausesFor("playing", null, pad(1)), 0);
  assert.match(hint("paused", null, pad(1)), /^Blue's gamepad is no longer connected\./);
});

test("a gamepad that goes in a pause for something else is told there; unanswered, the round pauses again", () => {
  const { lost, hint, pausesFor } = twoPads();
  assert.match(hint("paused", pad(0)), /^Red's gamepad is no longer connected\./);
  assert.equal(hint("paused", pad(0), pad(1)), "", "it is back");
  hint("paused", pad(0));
  lost.forget();
  assert.equal(pausesFor("playing", pad(0)), null, "somebody has gone on without it");
  hint("paused", pad(0), driven(1));
  assert.equal(pausesFor("paused", pad(0)), null);
  assert.equal(pausesFor("countdown", pad(0)), null);
  assert.equal(pausesFor("playing", pad(0)), 1, "the pause was over before anybody had answered");
});

test("when a pause for a gamepad ran out, the round pauses for the next one that goes", () => {
  const { pausesFor } = twoPads();
  assert.equal(pausesFor("playing", pad(0)), 1);
  for (const phase of ["paused", "countdown", "playing"]) assert.equal(pausesFor(phase, pad(0)), null);
  assert.equal(pausesFor("playing"), 0);
});

test("whose gamepad a strange one replaces is not known before it is used", () => {
  const { hint } = twoPads();
  hint("playing");
  assert.match(hint("paused", null, null, pad(2)), /^Your gamepad is no longer connected\./);
});
