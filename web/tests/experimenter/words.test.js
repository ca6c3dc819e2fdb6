// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import {
  actionsFor,
  atWords,
  codeWords,
  facts,
  GROUPS,
  isIn,
  linkPill,
  alertWords,
  noteWords,
  pausePill,
  recordingPill,
  seatNames,
  sorted,
  summaryWords,
  tickPill,
  timeWords,
  whereWords,
} from "../../experimenter/words.js";
import { speak } from "../text/support.js";

speak("en");

/** @typedef {import("../../experimenter/words.js").ParticipantRow} Row */

/** @param {Partial<Row>} [change] @returns {Row} */
const row = (change) => ({
  pid: "P4K7Q2",
  unit: 3,
  partner_letter: "A",
  partner_pid: null,
  seat: 0,
  step: "play/1/HandOff-1",
  kind: "round",
  position: { done: 9, total: 24 },
  round: { number: 8, of: 12 },
  since_s: 40,
  present: true,
  rtt_ms: 24,
  room: "r1",
  phase: "playing",
  tick: 310,
  limit_ticks: 500,
  late_ms: 1.3,
  missed: 0,
  recording: "recording",
  outcome: null,
  code_given: false,
  ...change,
});

test("where somebody is says round, partner and how it ended", () => {
  assert.equal(whereWords(row()), "Round 8 of 12");
  assert.equal(whereWords(row({ kind: "questionnaire", partner_letter: "B" })), "Questions, Partner B");
  assert.equal(whereWords(row({ kind: "waiting" })), "Waiting for a partner");
  assert.equal(whereWords(row({ kind: "code", outcome: "partner-left" })), "Finished · partner left");
  assert.equal(whereWords(row({ kind: "code", outcome: "done", kept: false })), "Finished · done, data deleted");
  assert.equal(whereWords(row({ kind: "something-new" })), "something-new");
});

test("blue is named before red, partners by their letter or their own pseudonym", () => {
  assert.deepEqual(seatNames(row()), ["P4K7Q2", "Partner A"]);
  assert.deepEqual(seatNames(row({ seat: 1, partner_letter: null, partner_pid: "PX93LM" })), ["PX93LM", "P4K7Q2"]);
  assert.equal(seatNames(row({ kind: "break" })), null);
  assert.equal(seatNames(row({ outcome: "done" })), null);
});

test("times are of the round while one runs, else of the step", () => {
  assert.equal(timeWords(row()), "0:31 / 0:50");
  assert.equal(timeWords(row({ phase: "paused" })), "0:31 / 0:50, paused");
  assert.equal(timeWords(row({ tick: null })), "0:40");
  assert.equal(timeWords(row({ outcome: "done" })), "");
});

test("pills are coloured by what needs attention", () => {
  assert.deepEqual(linkPill(row()), { words: "24 ms", tone: "ok" });
  assert.deepEqual(linkPill(row({ present: false })), { words: "away", tone: "attention" });
  assert.deepEqual(linkPill(row({ rtt_ms: 400 })), { words: "400 ms", tone: "bad" });
  assert.deepEqual(tickPill(row({ late_ms: 31 })), { words: "31.0 ms late", tone: "attention" });
  assert.deepEqual(tickPill(row({ missed: 2 })), { words: "2 missed", tone: "bad" });
  assert.deepEqual(tickPill(row({ late_ms: 8.4 })), { words: "8.4 ms late", tone: "ok" });
  assert.deepEqual(tickPill(row({ late_ms: null })), { words: "–", tone: "" });
  assert.deepEqual(recordingPill(row({ recording: "the disk is full" })), { words: "not recording", tone: "bad" });
});

test("who is away comes first, who has finished last, else in the order of their coming", () => {
  const rows = [
    row({ pid: "A", outcome: "done" }),
    row({ pid: "B" }),
    row({ pid: "C", present: false }),
    row({ pid: "D" }),
  ];
  assert.deepEqual(
    sorted(rows).map(({ pid }) => pid),
    ["C", "B", "D", "A"],
  );
});

test("a pause says since when, whoever began it, also between rounds", () => {
  const between = { kind: "questionnaire", room: null, tick: null, phase: "" };
  assert.deepEqual(pausePill(row()), { words: "–", tone: "" });
  assert.deepEqual(pausePill(row({ ...between, paused: true, paused_s: 72 })), {
    words: "paused 1:12",
    tone: "attention",
  });
  assert.equal(pausePill(row({ phase: "paused", paused_s: 5 })).words, "paused in the game 0:05");
  const lost = (/** @type {string} */ pid) => pausePill(row({ phase: "paused", paused_s: 5, waits_for: [pid] })).words;
  assert.deepEqual([lost(row().pid), lost("POTHER")], ["connection lost 0:05", "waits for the partner 0:05"]);
  assert.equal(pausePill(row({ outcome: "done", paused: true, paused_s: 5 })).words, "–");
});

test("who has finished is shown with code and minutes", () => {
  assert.equal(codeWords(row({ outcome: "done", code: "K7QX4WPL2M", minutes: 61.58 })), "Code K7QX4WPL2M · 61.6 min");
  assert.equal(codeWords(row({ outcome: "declined", code: null })), "");
  assert.equal(codeWords(row()), "");
});

test("a filter shows one group", () => {
  const groups = (/** @type {Partial<Row>} */ change) => GROUPS.filter((group) => isIn(row(change), group));
  assert.deepEqual(groups({}), ["all", "playing"]);
  assert.deepEqual(groups({ phase: "paused" }), ["all", "playing", "paused"]);
  assert.deepEqual(groups({ room: null, kind: "waiting", present: false }), ["all", "away", "waiting"]);
  assert.deepEqual(groups({ outcome: "done", room: null, present: false }), ["all", "finished"]);
});

test("a reason is asked while the round stands still, where the action ends it", () => {
  const holding = (/** @type {Partial<Row>} */ change) =>
    actionsFor(row({ episode: "e1", ...change })).flatMap(({ action, holds }) => (holds ? [action] : []));
  assert.deepEqual(holding({}), ["restart-round", "kick"]);
  assert.deepEqual(holding({ paused: true }), ["restart-round", "kick"], "another dialog may end its pause first");
  assert.deepEqual(holding({ room: null, kind: "form" }), []);
});

test("only what makes sense now can be done for somebody", () => {
  const names = (/** @type {Partial<Row>} */ change) => actionsFor(row(change)).map(({ action }) => action);
  const last = { episode: "e1", number: 3, map: "HandOff", title: "Hand Off", valid: true };
  assert.deepEqual(names({ last_round: last }), ["pause", "restart-round", "invalid", "note", "kick"]);
  assert.deepEqual(names({ kind: "form", room: null, unit: null }), ["note", "kick"]);
  assert.deepEqual(names({ paused: true, room: null }), ["resume", "note", "kick"]);
  assert.deepEqual(names({ outcome: "done", room: null, last_round: last }), ["invalid", "note"]);
  assert.deepEqual(names({ episode: "e2", last_round: null }), ["pause", "restart-round", "note", "kick"]);
  const labels = (/** @type {boolean} */ valid) => actionsFor(row({ last_round: { ...last, valid } }))[2]?.label;
  assert.equal(labels(true), "Mark round 3 invalid (Hand Off)");
  assert.equal(labels(false), "Count round 3 again (Hand Off)");
});

test("the head counts people, the cards say when something is wrong", () => {
  const server = { late_p99_ms: 1.3, missed: 0, ticks: 184200, disk_free_mb: 38000, recordings: 412, partial: 0 };
  const state = {
    study: { id: "s", title: "S" },
    paused: false,
    counts: { planned: 32, finished: 21, group: 1, active: 4, waiting: 1 },
    participants: [],
    alerts: [],
    notes: [],
    server,
  };
  assert.equal(summaryWords(state), "21 of 32 finished · 4 here · 1 waiting for a partner");
  assert.deepEqual(
    facts(state).map(({ value, tone }) => [value, tone]),
    [
      ["21 of 32", ""],
      ["1.3 ms", ""],
      ["412", ""],
      ["38 GB", ""],
    ],
  );
  const pairs = { ...state, counts: { ...state.counts, group: 2 } };
  assert.equal(summaryWords(pairs), "21 of 32 pairs finished · 4 here · 1 waiting for a partner");
  assert.deepEqual([facts(state)[0]?.title, facts(pairs)[0]?.title], ["Finished", "Finished pairs"]);
  const bad = facts({ ...state, server: { ...server, missed: 300, disk_free_mb: 300 } });
  assert.deepEqual(
    bad.map(({ tone }) => tone),
    ["", "bad", "", "bad"],
  );
});

test("an alert is said in the reader's language, an unknown one in the server's words", () => {
  const alert = { id: 1, at: 0, about: "gone", text: "English.", values: { pid: "P1", partner: "P2" }, detail: "" };
  speak("de");
  assert.equal(alertWords(alert), "P1 ist nicht zurückgekommen; P2 hat einen Code bekommen.");
  assert.equal(alertWords({ ...alert, about: "new" }), "English.");
  const untried = { ...alert, about: "controls", values: { pid: "P1", controls: ["grab", "left"] } };
  assert.equal(alertWords(untried), "P1 hat weitergemacht, ohne alles auszuprobieren: Greifen und links.");
  speak("en");
});

test("a note of an action names it as the menu does", () => {
  assert.equal(noteWords("kick: Fell asleep"), "End the study for them: Fell asleep");
  assert.equal(noteWords("restart-round: A fire drill"), "Restart the round: A fire drill");
  assert.equal(noteWords("invalid: kick: again"), "Mark the last round invalid: kick: again");
  assert.equal(noteWords("valid: A mistake"), "Count the round again: A mistake");
  assert.equal(noteWords("They said: fine"), "They said: fine");
});

test("notes and alerts of another day say the day", () => {
  const now = new Date(2026, 10, 28, 9, 0);
  const at = (/** @type {number} */ day) => new Date(2026, 10, day, 14, 5).getTime() / 1000;
  assert.match(atWords(at(28), now), /^(14:05|02:05.PM)$/);
  assert.match(atWords(at(27), now), /Nov.* 27.*2026.*05/);
});
