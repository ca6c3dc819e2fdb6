import assert from "node:assert/strict";
import { test } from "node:test";

import { contrast, readable } from "../../core/colours.js";
import { outline, radiusOf } from "../../shapes.js";
import {
  companyText,
  heldText,
  connectionWords,
  lostText,
  pauseLimitText,
  playingWords,
  reasonText,
  seatName,
  taskSentence,
  waitingForText,
  waitingWords,
} from "../../play/seat_phrases.js";
import { speak } from "../text/support.js";

speak("en");

/** @param {Partial<import("../../messages.js").SeatState>} [more] @returns {import("../../messages.js").SeatState} */
const seat = (more) => ({
  colour: "blue",
  kind: "human",
  name: "",
  open: false,
  present: true,
  ready: false,
  device: "",
  rtt_ms: -1,
  visible: true,
  ...more,
});

/** @param {string} shape @param {string} size */
const item = (shape, size) => ({ id: 0, shape, size, scale: 0.1, mass: 0.1, x: 0, y: 0, angle: 0 });

/** @param {...import("../../view/render.js").Item} items */
const map = (...items) => ({
  name: "",
  title: "",
  number: 0,
  mode: "",
  description: "",
  walls: [],
  items,
  goals: [{ x0: 0, y0: 0, x1: 1, y1: 1 }],
  robots: { blue: { x: 0, y: 0, angle: 0 }, red: { x: 0, y: 0, angle: 0 } },
});

/** @param {[number, number]} held */
const view = (held) => ({ poses: [], held, delivered: [] });

test("a pause says how long it lasts at most where somebody waits", () => {
  /** @param {import("../../messages.js").SeatState[]} seats @param {string} [code] @param {number} [seconds] */
  const limit = (seats, code = "paused", seconds = 40) => pauseLimitText({ reason_code: code, seats }, seconds);
  assert.equal(limit([seat({ ready: true }), seat()]), "The game goes on in 40 seconds at the latest.");
  const left = seat({ colour: "red", present: false });
  assert.equal(limit([seat({ ready: true }), left], "waiting"), "Red has 40 seconds to come back.");
  assert.equal(limit([seat(), { ...left, name: "Ada" }], "waiting", 1), "Ada has 1 second to come back.");
  assert.equal(limit([seat({ present: false }), left], "waiting"), "Blue and Red have 40 seconds to come back.");
  assert.equal(
    limit([seat({ ready: true }), seat()], "paused", 599),
    "The game goes on in 9:59 minutes at the latest.",
  );
  assert.equal(limit([seat(), seat()]), "");
  assert.equal(limit([seat(), seat({ kind: "agent", ready: true })]), "");
  assert.equal(limit([seat({ ready: true }), seat()], "study_paused"), "");
  assert.equal(limit([seat({ ready: true }), seat({ present: false })], "study_paused"), "", "not 86,400 seconds");
  assert.equal(pauseLimitText(null, 40), "");
});

test("what a seat does is said in words", () => {
  const items = map(item("square", "small"), item("star", "large"), item("circle", "middle"));
  const words = (/** @type {[number, number]} */ held, /** @type {number[]} */ own) =>
    playingWords(seat(), 1, items, view(held), own);
  assert.equal(words([-1, -1], [0]), "carrying nothing");
  assert.equal(words([-1, 0], [0]), "carrying a square");
  assert.equal(words([-1, 1], [0]), "waiting for your help");
  assert.equal(words([-1, 1], []), "waiting for help");
  assert.equal(words([-1, 1], [1]), "holding a star: too heavy for one");
  assert.equal(words([1, 1], [0]), "carrying a star together");
  assert.equal(words([-1, 2], [0]), "carrying a circle alone, slowly");
  assert.equal(playingWords(seat({ present: false }), 1, items, view([-1, 0]), [0]), "reconnecting…");
  assert.equal(playingWords(seat({ visible: false }), 1, items, view([-1, 0]), [0]), "away from the game");
});

test("whoever reads the page is not away from it, though the server has not told yet that they are back", () => {
  const back = seat({ visible: false });
  assert.equal(playingWords(back, 1, map(), view([-1, -1]), [1]), "carrying nothing");
  assert.equal(waitingWords(back, "lobby", true), "getting ready");
  assert.equal(waitingWords({ ...back, ready: true }, "lobby", true), "ready");
});

test("a seat before the round", () => {
  assert.equal(waitingWords(seat({ open: true, present: false }), "lobby"), "not here yet");
  assert.equal(waitingWords(seat(), "round_over"), "getting ready");
  assert.equal(waitingWords(seat({ ready: true }), "lobby"), "ready");
  assert.equal(waitingWords(seat({ ready: true, visible: false }), "lobby"), "ready, but away from the game");
  assert.equal(waitingWords(seat({ visible: false }), "round_over"), "away from the game");
  assert.equal(waitingWords(seat({ present: false, visible: false }), "lobby"), "not here yet");
  assert.equal(waitingWords(seat({ kind: "idle", ready: true }), "lobby"), "does nothing");
  assert.equal(waitingWords(seat(), "series_over"), "");
  assert.equal(waitingWords(seat({ ready: true }), "series_over"), "ready");
  assert.equal(waitingWords(seat({ present: false }), "round_over"), "no longer here");
  assert.equal(waitingWords(seat({ present: false }), "series_over"), "no longer here");
  assert.equal(waitingWords(seat({ kind: "agent", ready: true }), "series_over"), "");
});

test("of the other people is said whether they are here and ready, of computer players nothing", () => {
  const room = (/** @type {Partial<import("../../messages.js").SeatState>} */ other) =>
    companyText({ phase: /** @type {const} */ ("lobby"), seats: [seat(), seat(other)] }, [0]);
  assert.equal(room({ open: true, present: false }), "Partner: not here yet");
  assert.equal(room({}), "Partner: getting ready");
  assert.equal(room({ ready: true }), "Partner: ready");
  assert.equal(room({ kind: "agent", name: "scripted", ready: true }), "");
  assert.equal(companyText({ phase: "lobby", seats: [seat(), seat()] }, [0, 1]), "", "both at this screen");
  assert.equal(companyText({ phase: "series_over", seats: [seat(), seat()] }, [0]), "", "reads the result");
});

test("of a server that restarts is said that nothing begins, whoever is ready", () => {
  const room = {
    phase: /** @type {const} */ ("round_over"),
    reason_code: /** @type {const} */ ("restart_soon"),
    seats: /** @type {[any, any]} */ ([seat(), seat({ ready: true })]),
  };
  const told = "The server restarts in a moment; the next round begins after that.";
  assert.deepEqual([heldText(room), companyText(room, [0])], [told, told]);
  assert.deepEqual([heldText({ ...room, reason_code: "left" }), heldText(null)], ["", ""]);
});

test("who is not ready yet, in a sentence or as a name, or will not be", () => {
  const text = (/** @type {Partial<import("../../messages.js").SeatState>} */ other, watching = false) =>
    waitingForText(seat(other), watching, "lobby");
  assert.equal(text({}), "Waiting for your partner.");
  assert.equal(text({ kind: "agent", name: "scripted" }), "Not ready yet: Computer partner");
  assert.equal(text({ name: "Partner A" }), "Not ready yet: Partner A");
  assert.equal(text({}, true), "Not ready yet: Blue");
  assert.equal(text({ colour: "red", kind: "remote" }, true), "Not ready yet: Red");
  assert.equal(text({ name: "Kim" }, true), "Not ready yet: Kim");
  assert.equal(waitingForText(seat({ present: false }), false, "series_over"), "Partner: no longer here");
});

test("names: mine, the partner's, an agent's", () => {
  assert.deepEqual([seatName(seat(), true), seatName(seat(), false)], ["You", "Partner"]);
  assert.equal(seatName(seat(), false, true), "A person", "whoever watches has no partner");
  assert.equal(seatName(seat({ kind: "agent", name: "scripted" }), false), "Computer partner");
  assert.equal(seatName(seat({ kind: "agent", name: "bass@all" }), false), "Trained partner (BASS)");
  assert.equal(seatName(seat({ kind: "ghost", name: "scripted" }), false), "Recording of Computer partner");
  assert.equal(seatName(seat({ kind: "ghost", name: "person-k3x9ab" }), false), "Recording of the other player");
  assert.equal(seatName(seat({ kind: "ghost", name: "P7KXM2Q" }), false), "Recording of the other player");
  assert.equal(seatName(seat({ kind: "ghost", name: "person-Careful" }), false), "Recording of person-Careful");
  assert.equal(seatName(seat({ kind: "ghost" }), false), "Recording");
  assert.equal(seatName(seat({ name: "Ada" }), false), "Ada");
});

test("the task names only what this map asks for", () => {
  assert.equal(taskSentence(map(item("star", "small"))), "Carry everything into the green area.");
  assert.match(taskSentence(map(item("star", "small"), item("star", "large"))), /marked 2 need both/);
  assert.equal(
    taskSentence(map(item("star", "large")), true),
    "They carry everything into the green area. Items marked 2 need both of them.",
  );
  assert.match(taskSentence(map(item("star", "middle"))), /1\u2060–\u20602 are faster/);
});

test("the connection is a word and a colour", () => {
  assert.deepEqual(connectionWords("open", false, 23.6), { words: "good · 24 ms", state: "ok" });
  assert.deepEqual(connectionWords("open", false, 150), { words: "fair · 150 ms", state: "attention" });
  assert.deepEqual(connectionWords("open", true, 20), { words: "stalled", state: "bad" });
  assert.deepEqual(connectionWords("reconnecting", false, 20), { words: "lost", state: "bad" });
  assert.deepEqual(connectionWords("over", false, -1), { words: "closed", state: "" }, "a full room: nothing broke");
});

test("regular shapes have the area of a circle of their scale, the triangle 0.64 of it", () => {
  const area = (/** @type {[number, number][]} */ points) =>
    points.reduce((sum, [x, y], index) => {
      const [nextX, nextY] = points[(index + 1) % points.length];
      return sum + (x * nextY - nextX * y) / 2;
    }, 0);
  for (const [shape, share] of /** @type {const} */ ([
    ["square", 1],
    ["rectangle", 0.5],
    ["pentagon", 1],
    ["hexagon", 1],
    ["octagon", 1],
    ["triangle", 0.64],
  ])) {
    assert.ok(Math.abs(area(outline(shape, 0.1)) - share * Math.PI * 0.01) < 1e-9, shape);
  }
  assert.deepEqual(
    outline("star", 0.1)[0].map((value) => Math.abs(Number(value.toFixed(9)))),
    [0, 0.13],
  );
  assert.equal(radiusOf("circle", 0.1), 0.1);
  assert.throws(() => outline("heart", 0.1), RangeError);
});

test("the better readable of two inks is chosen", () => {
  assert.equal(readable("#ffffff", "#ffffff", "#18212c"), "#18212c");
  assert.equal(readable("#2a333f", "#ffffff", "#18212c"), "#ffffff");
  assert.ok(Math.abs(contrast("#ffffff", "#000000") - 21) < 1e-9);
});

test("a reason with two players is in the plural", () => {
  const reason = (/** @type {string[]} */ ...players) =>
    reasonText({ reason: "in English", reason_code: "paused", reason_values: { players } });
  assert.equal(reason("blue", "red"), "Blue and Red paused the game.");
  speak("de");
  assert.equal(reason("blue"), "Blau hat das Spiel angehalten.");
  assert.equal(reason("blue", "red"), "Blau und Rot haben das Spiel angehalten.");
  speak("en");
});

test("who paused alone is told that it was they, everybody else who it was", () => {
  const room = (/** @type {string[]} */ players, name = "") => ({
    reason: "",
    reason_code: /** @type {const} */ ("paused"),
    reason_values: { players },
    seats: /** @type {[any, any]} */ ([seat({ name }), seat({ colour: "red", kind: "agent" })]),
  });
  assert.equal(reasonText(room(["blue"]), [0]), "You paused the game.");
  assert.equal(reasonText(room(["Ada"], "Ada"), [0]), "You paused the game.");
  assert.equal(reasonText(room(["blue"]), [1]), "Blue paused the game.");
  assert.equal(reasonText(room(["blue"]), [0, 1]), "Blue paused the game.", "two at one screen");
  assert.equal(reasonText(room(["blue"])), "Blue paused the game.", "whoever watches");
});

test("whose line was down is told so, and the partner who did not come back", () => {
  const told = (/** @type {"not_back" | "unsteady"} */ code, /** @type {number[]} */ own, players = ["blue"]) =>
    reasonText(
      {
        reason: "",
        reason_code: code,
        reason_values: { players },
        seats: /** @type {[any, any]} */ ([seat(), seat({ colour: "red" })]),
      },
      own,
    );
  assert.equal(told("not_back", [0]), "You were away for too long.");
  assert.equal(told("not_back", [1]), "Blue did not come back.");
  assert.equal(told("not_back", [0], ["blue", "red"]), "Blue and Red did not come back.");
  assert.equal(told("unsteady", [0]), "You lost the connection too often.");
  assert.equal(told("unsteady", [1]), "Blue lost the connection too often.");
});

test("a lost connection: nothing at first, then why, where the server said so", () => {
  const why = "Too many people are already watching.";
  assert.equal(lostText("reconnecting", 100, why), "");
  assert.equal(lostText("reconnecting", 60_000), "Connection lost. Trying again…");
  assert.equal(lostText("reconnecting", 60_000, why), why);
  assert.equal(lostText("open", 60_000, why), "");
});
