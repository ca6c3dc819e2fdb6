// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import {
  facts,
  linkPill,
  phaseWords,
  recordingPill,
  refusalWords,
  remarkWords,
  seatWords,
  summaryWords,
  timeWords,
  uptime,
} from "../../admin/words.js";
import { speak } from "../text/support.js";

speak("en");

/** @param {Partial<import("../../messages.js").SeatState>} seat */
const seat = (seat) => ({
  colour: "blue",
  kind: /** @type {const} */ ("human"),
  name: "",
  open: false,
  present: true,
  visible: true,
  ready: true,
  device: "",
  rtt_ms: -1,
  ...seat,
});

/** @type {import("../../admin/words.js").AdminState} */
const STATE = {
  uptime_s: 7_530,
  late_ms: { p50: 0.21, p99: 1.34 },
  ticks: 184_200,
  missed_ticks: 0,
  deadline_misses: 1,
  cpu_percent: 7.4,
  rss_mb: 143.2,
  sockets: 5,
  disk_free_mb: 38_123,
  finalising: 0,
  unfinished: {},
  refusal: "",
  refusal_code: "",
  refusal_values: {},
  rooms: [],
};

const ROOM = {
  room: "a",
  phase: "playing",
  reason: "",
  reason_code: "",
  reason_values: {},
  map: "HandOff",
  title: "Hand Off",
  round: 1,
  rounds: 1,
  tick: 1,
  limit_ticks: 500,
  delivered: 0,
  items: 4,
  recording: true,
  recording_problem: "",
  recording_problem_code: "",
  spectators: 0,
  rooms_of_address: 1,
  seats: [],
};

test("phases are words, with the round where there are several", () => {
  assert.equal(phaseWords({ phase: "playing", round: 8, rounds: 12 }), "Playing · round 8 of 12");
  assert.equal(phaseWords({ phase: "lobby", round: 1, rounds: 1 }), "Waiting for players");
});

test("time is played time of the limit, without a limit alone, and nothing before the game", () => {
  assert.equal(timeWords({ phase: "playing", tick: 195, limit_ticks: 500 }), "0:19 / 0:50");
  assert.equal(timeWords({ phase: "playing", tick: 640, limit_ticks: 0 }), "1:04");
  assert.equal(timeWords({ phase: "lobby", tick: 0, limit_ticks: 500 }), "");
});

test("the link is the slowest of those who play from afar, agents do not count", () => {
  const agent = seat({ kind: "agent", rtt_ms: -1 });
  const link = (/** @type {Parameters<typeof seat>[0]} */ blue, red = agent, phase = "playing") =>
    linkPill({ seats: [seat(blue), red], phase });
  assert.deepEqual(link({ rtt_ms: 24.4 }), { words: "24 ms", tone: "ok" });
  assert.deepEqual(link({ rtt_ms: 24 }, seat({ rtt_ms: 140 })), { words: "140 ms", tone: "attention" });
  assert.deepEqual(link({ rtt_ms: 300 }), { words: "300 ms", tone: "bad" });
  assert.deepEqual(link({ present: false }), { words: "reconnecting", tone: "attention" });
  assert.deepEqual(link({ present: false, open: true }), { words: "–", tone: "" });
  assert.deepEqual(link({ present: false }, agent, "series_over"), { words: "–", tone: "" });
});

test("a game that should be recorded and is not stands out", () => {
  assert.equal(recordingPill({ phase: "playing", recording: false, recording_problem: "disk full" }).tone, "bad");
  assert.equal(recordingPill({ phase: "playing", recording: true, recording_problem: "" }).words, "recording");
  assert.equal(
    recordingPill({ phase: "lobby", recording: true, recording_problem: "" }).words,
    "–",
    "nothing to record yet",
  );
  assert.equal(recordingPill({ phase: "playing", recording: false, recording_problem: "" }).words, "–");
});

test("what the server refuses or cannot record is said in the reader's language, else in the server's words", () => {
  const busy = { ...STATE, refusal: "Busy.", refusal_code: "busy", refusal_values: {} };
  const row = { ...ROOM, recording_problem: "cannot write /x", recording_problem_code: "disk_full" };
  speak("de");
  assert.match(refusalWords(busy), /ausgelastet/);
  assert.equal(refusalWords(STATE), "");
  assert.match(refusalWords({ ...busy, refusal_code: "new" }), /Busy\.$/);
  assert.equal(remarkWords(row), "Nicht aufgezeichnet: Der Speicherplatz ist voll.");
  const lost = { ...row, reason: "Red lost.", reason_code: "lost", reason_values: { players: ["red"] } };
  assert.equal(remarkWords(lost), "Verbindung verloren: Rot.");
  speak("en");
});

test("seats say who sits there", () => {
  assert.equal(seatWords(seat({ open: true, present: false })), "free seat");
  assert.equal(seatWords(seat({ name: "P7", device: "gamepad" })), "P7 · gamepad");
  assert.equal(seatWords(seat({ name: "P7", present: false, device: "gamepad" })), "P7, away");
  assert.equal(seatWords(seat({ kind: "agent", name: "bass@all" })), "Trained partner (BASS)");
  assert.equal(seatWords(seat({ kind: "idle" })), "nobody");
});

test("uptime is minutes, then hours", () => {
  assert.deepEqual([59, 60, 3_599, 3_600, 7_530].map(uptime), ["0 min", "1 min", "59 min", "1 h 0 min", "2 h 5 min"]);
});

test("the summary counts rooms and people who are there", () => {
  const rooms = [{ ...ROOM, seats: [seat({}), seat({ kind: "agent" })] }];
  assert.equal(summaryWords({ ...STATE, rooms }), "1 room · 1 player · up for 2 h 5 min");
});

test("behind a proxy the summary says which node it is about, and counts the rooms of all", () => {
  const nodes = [
    { name: "a", state: "serving", rooms: 1 },
    { name: "b", state: "draining", rooms: 4 },
    { name: "c", state: "ended", rooms: 9 },
  ];
  const said = summaryWords({ ...STATE, rooms: [], cluster: { node: "a", nodes } });
  assert.equal(said, "0 rooms · 0 players · up for 2 h 5 min · on node a · all 2 nodes: 5 rooms");
  const alone = summaryWords({ ...STATE, rooms: [], cluster: { node: "a", nodes: nodes.slice(0, 1) } });
  assert.equal(alone, "0 rooms · 0 players · up for 2 h 5 min · on node a");
});

test("four facts, in red where a person would notice", () => {
  assert.deepEqual(
    facts(STATE).map(({ value, tone }) => [value, tone]),
    [
      ["1.3 ms", ""],
      ["5", ""],
      ["7 %", ""],
      ["38 GB free", ""],
    ],
  );
  const bad = { ...STATE, missed_ticks: 200, cpu_percent: 97, disk_free_mb: 400 };
  assert.deepEqual(
    facts(bad).map(({ value, tone }) => [value, tone]),
    [
      ["1.3 ms", "bad"],
      ["5", ""],
      ["97 %", "bad"],
      ["400 MB free", "bad"],
    ],
  );
});

test("figures are written as the reader's language does", () => {
  speak("de");
  const [few] = facts({ ...STATE, ticks: 255_693, missed_ticks: 5 });
  assert.deepEqual([few.tone, few.detail], ["", "p50 0,2 ms · 5 von 255.693 verpasst"]);
  const [late] = facts({ ...STATE, missed_ticks: 1234 });
  assert.equal(late.value, "1,3 ms");
  assert.equal(late.detail, "p50 0,2 ms · 1.234 von 184.200 verpasst");
  speak("en");
});

test("recordings that could not be finished are seen", () => {
  const [, , , disk] = facts({ ...STATE, unfinished: { "a.mcap.journal": "cannot write: No space left on device" } });
  assert.equal(disk?.detail, "1 recording could not be finished yet; it is tried again");
  assert.equal(disk?.tone, "bad");
  assert.equal(facts({ ...STATE, finalising: 2 })[3]?.detail, "2 recordings being finished");
});
