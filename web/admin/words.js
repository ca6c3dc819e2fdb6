// @ts-check
/*
 * The running server in words: from GET /api/admin/state to short texts.
 */

import { freeDisk, isLate, milliseconds, missesMany, NO_PILL, roundTripPill } from "../components/dashboard.js";
import { clockText, secondsOf } from "../core/ticks.js";
import { reasonText, seatName } from "../play/seat_phrases.js";
import { has, say } from "../text/catalogue.js";

/** @typedef {import("../components/dashboard.js").Pill} Pill */
/** @typedef {import("../components/dashboard.js").Fact} Fact */
/** @typedef {import("../messages.js").SeatState} Seat */
/**
 * @typedef {object} RoomRow
 * @property {string} room
 * @property {string} phase
 * @property {string} reason in English
 * @property {string} reason_code
 * @property {Record<string, any>} reason_values
 * @property {string} map its name
 * @property {string} title the map's, which tells maps of somebody's own apart
 * @property {number} round from 1
 * @property {number} rounds
 * @property {number} tick
 * @property {number} limit_ticks 0: none
 * @property {number} delivered
 * @property {number} items
 * @property {boolean} recording
 * @property {string} recording_problem in English
 * @property {string} recording_problem_code
 * @property {number} spectators
 * @property {number} rooms_of_address open rooms of the address that opened this one, itself included; 0: nobody's
 * @property {Seat[]} seats
 */
/**
 * @typedef {object} AdminState
 * @property {number} uptime_s
 * @property {{p50: number, p99: number}} late_ms
 * @property {number} ticks
 * @property {number} missed_ticks
 * @property {number} deadline_misses
 * @property {number} cpu_percent of one core
 * @property {number} rss_mb
 * @property {number} sockets
 * @property {number} disk_free_mb
 * @property {number} finalising recordings that are being finished
 * @property {Record<string, string>} unfinished why a recording could not be finished yet, by file
 * @property {string} refusal why no room can be opened now, in English; empty: one can
 * @property {string} refusal_code
 * @property {Record<string, unknown>} refusal_values
 * @property {RoomRow[]} rooms
 * @property {{node: string, nodes: {name: string, state: string, rooms: number}[]}} [cluster] of a node
 */

const CPU_PERCENT = 80; // of one core, above which it is too much

/** @param {Pick<RoomRow, "phase" | "round" | "rounds">} room */
export function phaseWords({ phase, round, rounds }) {
  const words = has(`admin.phase.${phase}`) ? say(`admin.phase.${phase}`) : phase;
  return rounds > 1 ? say("admin.phaseInRound", { phase: words, round, rounds }) : words;
}

/** Why a room waits, or why its round is not recorded. @param {RoomRow} room */
export function remarkWords(room) {
  const { recording_problem: problem, recording_problem_code: code } = room;
  return reasonText(room) || (has(`unrecorded.${code}`) ? say(`unrecorded.${code}`) : problem);
}

/** Why no room can be opened now; empty: one can. @param {AdminState} state */
export function refusalWords({ refusal, refusal_code: code, refusal_values: values }) {
  if (!refusal) return "";
  return say("admin.noNewGames", { reason: has(`refusal.${code}`) ? say(`refusal.${code}`, values) : refusal });
}

/** Time played of the limit: "0:19 / 0:50". @param {Pick<RoomRow, "tick" | "limit_ticks" | "phase">} room */
export function timeWords({ tick, limit_ticks, phase }) {
  if (phase === "lobby") return "";
  const played = clock(tick);
  return limit_ticks > 0 ? `${played} / ${clock(limit_ticks)}` : played;
}

/**
 * The worst connection of the people and programs in a room.
 * @param {Pick<RoomRow, "seats" | "phase">} room
 * @returns {Pill}
 */
export function linkPill({ seats, phase }) {
  const over = phase === "series_over" || phase === "closed"; // nobody is missed any more
  const joined = over ? [] : seats.filter(({ kind }) => kind === "human" || kind === "remote");
  if (joined.some(({ open, present }) => !open && !present)) {
    return { words: say("admin.reconnecting"), tone: "attention" };
  }
  const slowest = Math.max(-1, ...joined.filter(({ present }) => present).map(({ rtt_ms }) => rtt_ms));
  return slowest < 0 ? NO_PILL : roundTripPill(slowest);
}

/** @param {Pick<RoomRow, "phase" | "recording" | "recording_problem">} room @returns {Pill} */
export function recordingPill({ phase, recording, recording_problem }) {
  if (recording_problem) return { words: say("admin.notRecording"), tone: "bad" };
  const inRound = phase === "playing" || phase === "paused";
  return recording && inRound ? { words: say("dashboard.recording"), tone: "ok" } : NO_PILL;
}

/** @param {Seat} seat */
export function seatWords(seat) {
  const { kind, name, open, present, device } = seat;
  if (open) return say("admin.seat.free");
  const who = name ? seatName(seat, false, true) : say(`admin.seat.${kind}`);
  if (!present && (kind === "human" || kind === "remote")) return say("admin.seat.away", { who });
  return device && kind === "human" ? `${who} · ${say(`play.device.${device}`)}` : who;
}

/** @param {number} ticks */
function clock(ticks) {
  return clockText(Math.floor(secondsOf(ticks)));
}

/** "2 h 5 min". @param {number} seconds */
export function uptime(seconds) {
  const minutes = Math.floor(seconds / 60);
  if (minutes < 60) return say("admin.minutes", { minutes });
  return say("admin.hours", { hours: Math.floor(minutes / 60), minutes: minutes % 60 });
}

/** @param {AdminState} state */
export function summaryWords({ rooms, uptime_s, cluster }) {
  const people = rooms.flatMap(({ seats }) => seats).filter(({ kind, present }) => kind === "human" && present).length;
  const up = say("admin.upFor", { time: uptime(uptime_s) });
  const here = [say("admin.rooms", { count: rooms.length }), say("admin.players", { count: people }), up];
  return [...here, ...(cluster ? nodeWords(cluster) : [])].join(" · ");
}

/** Which node this is about, and the rooms of all. @param {NonNullable<AdminState["cluster"]>} cluster */
function nodeWords({ node, nodes }) {
  const running = nodes.filter(({ state }) => state === "serving" || state === "draining");
  const count = running.reduce((sum, { rooms }) => sum + rooms, 0);
  const all = { nodes: running.length, rooms: say("admin.rooms", { count }) };
  return [say("admin.node", { node }), ...(running.length > 1 ? [say("admin.allNodes", all)] : [])];
}

/** The cards above the rooms. @param {AdminState} state @returns {Fact[]} */
export function facts(state) {
  const { late_ms, missed_ticks: missed, ticks, cpu_percent } = state;
  const disk = freeDisk(state.disk_free_mb);
  return [
    {
      title: say("dashboard.lateTicks"),
      value: milliseconds(late_ms.p99, 1),
      detail: `p50 ${milliseconds(late_ms.p50, 1)} · ${say("dashboard.missedOf", { missed, ticks })}`,
      tone: isLate(late_ms.p99) || missesMany(missed, ticks) ? "bad" : "",
    },
    {
      title: say("admin.connections"),
      value: String(state.sockets),
      detail: say("admin.lateAnswers", { count: state.deadline_misses }),
      tone: "",
    },
    {
      title: say("admin.processor"),
      value: `${Math.round(cpu_percent)} %`,
      detail: say("admin.processor.detail", { memory: Math.round(state.rss_mb) }),
      tone: cpu_percent > CPU_PERCENT ? "bad" : "",
    },
    {
      title: say("dashboard.disk"),
      value: say("admin.disk.free", { size: disk.value }),
      detail: finishing(state),
      tone: Object.keys(state.unfinished).length > 0 ? "bad" : disk.tone,
    },
  ];
}

/** Whether every recording is whole. @param {AdminState} state */
function finishing({ finalising, unfinished }) {
  const failed = Object.keys(unfinished).length;
  if (failed > 0) return say("admin.unfinished", { count: failed });
  return finalising > 0 ? say("admin.finishing", { count: finalising }) : say("admin.allFinished");
}
