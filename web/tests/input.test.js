import assert from "node:assert/strict";
import { test } from "node:test";

import { Gamepads } from "../input/gamepad.js";
import { Keyboard } from "../input/keyboard.js";
import { DEFAULTS } from "../input/mapping.js";
import { LocalSeats } from "../input/seats.js";
import { InputSender, InputSenders } from "../input/sender.js";
import { CENTRED, driveFrom, strongest, withDeadZone } from "../input/stick.js";

const close = (/** @type {number} */ actual, /** @type {number} */ expected) =>
  assert.ok(Math.abs(actual - expected) < 1e-9, `${actual} is not ${expected}`);

test("a stick below the dead zone is centred, above it the range is full again", () => {
  assert.deepEqual(withDeadZone(0.2, 0.2, 0.3), CENTRED);
  close(withDeadZone(0.65, 0, 0.3).x, 0.5);
  const diagonal = withDeadZone(1, 1, 0.3);
  close(Math.hypot(diagonal.x, diagonal.y), 1);
  assert.deepEqual(withDeadZone(NaN, 0, 0.3), CENTRED);
});

test("headings look along +y at 0 and grow counter-clockwise", () => {
  close(driveFrom({ x: 0, y: 1 }, false, 9).heading, 0);
  close(driveFrom({ x: -1, y: 0 }, false, 9).heading, Math.PI / 2);
  close(driveFrom({ x: 1, y: 0 }, false, 9).heading, -Math.PI / 2);
  close(driveFrom({ x: 0.3, y: 0.4 }, false, 9).move, 0.5);
});

test("backward turns the robot round and still moves where the stick points", () => {
  const { move, heading } = driveFrom({ x: 0.6, y: 0.8 }, true, 0);
  close(move, -1);
  close(move * -Math.sin(heading), 0.6);
  close(move * Math.cos(heading), 0.8);
  assert.ok(heading >= -Math.PI && heading < Math.PI);
});

test("a centred stick keeps the heading", () => {
  assert.deepEqual(driveFrom(CENTRED, false, 1.25), { move: 0, heading: 1.25 });
});

test("two sticks of one person do not add up", () => {
  assert.deepEqual(strongest([{ x: 0.2, y: 0 }, { x: 0, y: -0.9 }, CENTRED]), { x: 0, y: -0.9 });
});

/** @param {string} type @param {string} code @param {object} [more] */
function key(type, code, more = {}) {
  return Object.assign(new Event(type, { cancelable: true }), { code, repeat: false, ...more });
}

/** A keyboard and what to press on it. */
function keyboard() {
  const target = new EventTarget();
  let changes = 0;
  const keys = new Keyboard(
    target,
    () => DEFAULTS.keys,
    () => (changes += 1),
  );
  /** @param {string} type @param {string} code @param {object} [more] */
  const send = (type, code, more) => {
    const event = key(type, code, more);
    target.dispatchEvent(event);
    return event;
  };
  return { keys, send, changes: () => changes };
}

test("a remote control that does not tell places drives and grabs", () => {
  const { keys, send } = keyboard();
  send("keydown", "", { key: "ArrowUp" });
  send("keydown", "", { key: "Enter" });
  const { stick, grabs } = keys.read(DEFAULTS.keys[1]);
  assert.deepEqual([stick, grabs], [{ x: 0, y: 1 }, 1]);
  send("keyup", "", { key: "ArrowUp" });
  assert.deepEqual(keys.read(DEFAULTS.keys[1]).stick, CENTRED);
  send("keydown", "", { key: "W" });
  assert.equal(keys.read(DEFAULTS.keys[0]).stick.y, 1);
});

test("a Shift key is not held for ever where only the other one's release is told", () => {
  const { keys, send } = keyboard();
  const backward = () => DEFAULTS.keys.map((set) => keys.read(set).backward);
  send("keydown", "ShiftLeft", { key: "Shift", shiftKey: true });
  send("keydown", "ShiftRight", { key: "Shift", shiftKey: true });
  assert.deepEqual(backward(), [true, true]);
  send("keyup", "ShiftRight", { key: "Shift", shiftKey: false });
  assert.deepEqual(backward(), [false, false]);
  send("keydown", "ShiftLeft", { key: "Shift", shiftKey: true });
  send("keydown", "KeyW", { key: "w", shiftKey: false });
  assert.deepEqual(backward(), [false, false], "any key tells");
});

test("what was let go beside the command key of a Mac, which nobody tells, is not held for ever", () => {
  const { keys, send, changes } = keyboard();
  send("keydown", "KeyW");
  send("keydown", "MetaLeft", { key: "Meta", metaKey: true });
  const before = changes();
  send("keyup", "MetaLeft", { key: "Meta" });
  assert.deepEqual([keys.read(DEFAULTS.keys[0]).stick, changes() - before], [CENTRED, 1]);
});

test("keys are a stick of length one, diagonals too", () => {
  const { keys, send } = keyboard();
  send("keydown", "KeyW");
  assert.deepEqual(keys.read(DEFAULTS.keys[0]).stick, { x: 0, y: 1 });
  send("keydown", "KeyD");
  close(keys.read(DEFAULTS.keys[0]).stick.x, Math.SQRT1_2);
  send("keyup", "KeyW");
  assert.deepEqual(keys.read(DEFAULTS.keys[0]).stick, { x: 1, y: 0 });
  assert.deepEqual(keys.read(DEFAULTS.keys[1]).stick, { x: 0, y: 0 });
});

test("a press shorter than a frame still grabs, and holding the key grabs once", () => {
  const { keys, send, changes } = keyboard();
  send("keydown", "Space");
  send("keydown", "Space", { repeat: true });
  send("keyup", "Space");
  assert.equal(keys.read(DEFAULTS.keys[0]).grabs, 1);
  assert.equal(keys.read(DEFAULTS.keys[0]).grabs, 0);
  assert.equal(changes(), 2);
});

test("bound keys do not scroll the page; other keys and shortcuts are left alone", () => {
  const { send, keys } = keyboard();
  assert.equal(send("keydown", "ArrowDown").defaultPrevented, true);
  assert.equal(send("keydown", "KeyQ").defaultPrevented, false);
  assert.equal(send("keydown", "KeyA", { ctrlKey: true }).defaultPrevented, false);
  assert.deepEqual(keys.read(DEFAULTS.keys[0]).stick, { x: 0, y: 0 });
});

test("losing the focus lets go of every key", () => {
  const { keys, send } = keyboard();
  send("keydown", "KeyW");
  send("keydown", "Space");
  keys.release();
  assert.deepEqual(keys.read(DEFAULTS.keys[0]), { stick: { x: 0, y: 0 }, backward: false, grabs: 0, pings: 0 });
});

/** @param {number} index @param {{x?: number, y?: number, down?: number[], values?: Record<number, number>}} state */
function pad(index, { x = 0, y = 0, down = [], values = {} } = {}) {
  const buttons = Array.from({ length: 17 }, (_, button) => ({
    pressed: down.includes(button),
    touched: false,
    value: values[button] ?? Number(down.includes(button)),
  }));
  return /** @type {Gamepad} */ (
    /** @type {unknown} */ ({ index, id: `pad ${index}`, connected: true, mapping: "standard", axes: [x, y], buttons })
  );
}

test("a gamepad's axes point down, its trigger is backward from half way, its A button grabs once per press", () => {
  /** @type {(Gamepad | null)[]} */
  let plugged = [null, pad(1, { y: -1, values: { 6: 0.6 }, down: [0] })];
  const gamepads = new Gamepads(() => plugged);
  const [first] = gamepads.read(DEFAULTS);
  assert.deepEqual([first.stick.x, first.stick.y, first.backward, first.grabs], [0, 1, true, 1]);
  assert.equal(gamepads.read(DEFAULTS)[0].grabs, 0);
  plugged = [];
  assert.deepEqual(gamepads.read(DEFAULTS), []);
  plugged = [null, pad(1, { down: [0] })];
  assert.equal(gamepads.read(DEFAULTS)[0].grabs, 1, "after plugging it in again");
});

test("the d-pad is a stick too", () => {
  const gamepads = new Gamepads(() => [pad(0, { down: [14] })]);
  assert.deepEqual(gamepads.read(DEFAULTS)[0].stick, { x: -1, y: 0 });
});

/** Devices whose state a test sets. */
function devices(/** @type {import("../input/seats.js").Device} */ first = "keyboard") {
  const board = keyboard();
  /** @type {{pads: (Gamepad | null)[], touch: import("../input/keyboard.js").Reading, used: boolean}} */
  const state = { pads: [], touch: { stick: CENTRED, backward: false, grabs: 0, pings: 0 }, used: false };
  const touch = {
    read: () => state.touch,
    get used() {
      return state.used;
    },
  };
  const seats = new LocalSeats({ keyboard: board.keys, gamepads: new Gamepads(() => state.pads), touch }, first);
  return { seats, state, send: board.send };
}

test("one person drives the one seat with every device, and the last one used is named", () => {
  const { seats, state, send } = devices();
  seats.hold([1]);
  send("keydown", "ArrowLeft");
  assert.deepEqual(seats.read(DEFAULTS).get(1), {
    stick: { x: -1, y: 0 },
    backward: false,
    grabs: 0,
    pings: 0,
    device: "keyboard",
  });
  send("keyup", "ArrowLeft");
  state.pads = [pad(0, { x: 1, down: [0] })];
  const reading = seats.read(DEFAULTS).get(1);
  assert.deepEqual([reading?.stick.x, reading?.grabs, reading?.device], [1, 1, "gamepad"]);
  state.pads = [];
  state.touch = { stick: { x: 0, y: 1 }, backward: true, grabs: 2, pings: 0 };
  state.used = true;
  assert.deepEqual(seats.read(DEFAULTS).get(1), { ...state.touch, device: "touch" });
});

test("fingers drive the first of two seats: the other one is shown its keys", () => {
  const { seats } = devices("touch");
  seats.hold([0, 1]);
  assert.deepEqual(
    seats.cards().map(({ device }) => device),
    ["touch", "keyboard"],
  );
  seats.hold([1]);
  assert.equal(seats.cards()[0].device, "touch");
});

test("the key and the button for pings count their presses, each for the seat that they drive", () => {
  const { seats, state, send } = devices();
  seats.hold([0, 1]);
  send("keydown", "KeyE");
  send("keyup", "KeyE");
  send("keydown", "KeyE");
  send("keydown", "Slash");
  assert.deepEqual(
    [...seats.read(DEFAULTS).values()].map(({ pings }) => pings),
    [2, 1],
  );
  state.pads = [pad(0, { down: [3] })];
  assert.equal(seats.read(DEFAULTS).get(0)?.pings, 1);
  assert.equal(seats.read(DEFAULTS).get(0)?.pings, 0, "held down");
});

test("two people at one screen have a key set each, and can change chairs", () => {
  const { seats, send } = devices();
  seats.hold([0, 1]);
  send("keydown", "KeyW");
  send("keydown", "Enter");
  const readings = seats.read(DEFAULTS);
  assert.deepEqual([readings.get(0)?.stick.y, readings.get(1)?.stick.y], [1, 0]);
  assert.deepEqual([readings.get(0)?.grabs, readings.get(1)?.grabs], [0, 1]);
  seats.swap();
  assert.equal(seats.read(DEFAULTS).get(1)?.stick.y, 1);
});

test("two gamepads belong to the seats in the order in which they are first used", () => {
  const { seats, state } = devices();
  seats.hold([0, 1]);
  state.pads = [pad(0), pad(1, { down: [0] })];
  assert.equal(seats.read(DEFAULTS).get(0)?.grabs, 1);
  state.pads = [pad(0, { down: [0] }), pad(1)];
  assert.equal(seats.read(DEFAULTS).get(1)?.grabs, 1);
  assert.deepEqual(
    seats.cards().map((card) => [card.seat, card.pad?.index, card.keySets]),
    [
      [0, 1, [0]],
      [1, 0, [1]],
    ],
  );
});

test("with one gamepad the other person has the whole keyboard, until it is unplugged", () => {
  const { seats, state, send } = devices();
  seats.hold([0, 1]);
  state.pads = [pad(0, { x: 1 })];
  send("keydown", "KeyW");
  const readings = seats.read(DEFAULTS);
  assert.deepEqual([readings.get(0)?.stick.x, readings.get(1)?.stick.y], [1, 1]);
  state.pads = [];
  assert.equal(seats.read(DEFAULTS).get(0)?.stick.y, 1);
  assert.equal(seats.cards()[0].pad, null);
});

/** @param {Partial<import("../input/seats.js").SeatReading>} [more] */
const reading = (more) => ({
  stick: CENTRED,
  backward: false,
  grabs: 0,
  pings: 0,
  device: /** @type {const} */ ("keyboard"),
  ...more,
});
const seen = { ackTick: 5, seenTick: 4 };

test("inputs go out on every change and otherwise twenty times a second", () => {
  const sender = new InputSender(1);
  assert.equal(sender.next(0, reading(), seen)?.seq, 1);
  assert.equal(sender.next(16, reading(), seen), null);
  const start = sender.next(17, reading({ stick: { x: 0, y: 1 } }), seen);
  assert.deepEqual(
    { ...start, heading: Math.abs(start?.heading ?? 9) },
    { seat: 1, seq: 2, ackTick: 5, seenTick: 4, move: 1, heading: 0, grabs: 0, device: 0, clientMs: 17 },
  );
  assert.equal(sender.next(60, reading({ stick: { x: 0, y: 1 } }), seen), null);
  assert.equal(sender.next(67, reading({ stick: { x: 0, y: 1 } }), seen)?.seq, 3);
});

test("a stick that swings goes out at most 25 times a second, its release at once", () => {
  const sender = new InputSender(0);
  let sent = 0;
  for (let now = 0; now < 1000; now += 16) {
    const stick = { x: Math.sin(now / 50), y: Math.cos(now / 50) };
    if (sender.next(now, reading({ stick, device: "gamepad" }), seen)) sent += 1;
  }
  assert.ok(sent <= 25, `${sent}`);
  assert.equal(sender.next(1000, reading({ device: "gamepad" }), seen)?.move, 0);
});

test("presses are counted, also those read while nothing was sent", () => {
  const sender = new InputSender(0);
  sender.next(0, reading(), seen);
  assert.equal(sender.next(1, reading({ grabs: 1 }), seen)?.grabs, 1);
  assert.equal(sender.next(2, reading({ grabs: 2 }), seen)?.grabs, 3);
  assert.equal(sender.neutral(3, seen).grabs, 3);
});

test("behind a dialog neutral input goes on twenty times a second, and says what has arrived", () => {
  /** @type {import("../messages.js").Input[]} */
  const sent = [];
  const senders = new InputSenders(
    (input) => sent.push(input),
    () => seen,
  );
  senders.hold([0, 1]);
  senders.send(1, reading({ stick: { x: 0, y: 1 }, grabs: 1, device: "gamepad" }), 0);
  for (let now = 1; now <= 1000; now += 10) senders.keepNeutral(now);
  const red = sent.filter(({ seat }) => seat === 1).slice(1);
  assert.deepEqual([red[0].clientMs, red[0].ackTick, red[0].grabs], [1, 5, 1]);
  assert.ok(red.every(({ move, device }) => move === 0 && device === 1));
  for (const seat of [0, 1]) {
    const count = sent.filter((input) => input.seat === seat).length;
    assert.ok(count >= 18 && count <= 22, `${count}`);
  }
});
