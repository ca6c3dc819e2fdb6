// @ts-check
/*
 * The running server in words for the experimenter. Pure: from GET /api/admin/state to short texts.
 */

import { clockText, secondsOf } from "../core/ticks.js";

/** @typedef {{words: string, tone: "" | "ok" | "attention" | "bad"}} Pill */
/** @typedef {import("../messages.js").SeatState} Seat */
/**
 * @typedef {object} RoomRow
 * @property {string} room
 * @property {string} phase
 * @property {string} [reason]
 * @property {string} map
 * @property {number} round from 1
 * @property {number} rounds
 * @property {number} tick
 * @property {number} limit_ticks 0: none
 * @property {number} delivered
 * @property {number} items
 * @property {boolean} recording
 * @property {string} recording_problem
 * @property {number} spectators
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
 * @property {string} refusal why no room can be opened now; empty: one can
 * @property {RoomRow[]} rooms
 */
/** @typedef {{title: string, value: string, detail: string, tone: "" | "bad"}} Fact */

const LATE_MS = 5; // p99 beyond which a person might notice
const CPU_PERCENT = 80;
const DISK_MB = 1000;

const PHASES = /** @type {Record<string, string>} */ ({
  lobby: "Waiting for players",
  countdown: "Starting",
  playing: "Playing",
  paused: "Paused",
  round_over: "Between rounds",
  series_over: "Finished",
  closed: "Closed",
});

/** @param {Pick<RoomRow, "phase" | "round" | "rounds">} room */
export function phaseWords({ phase, round, rounds }) {
  const words = PHASES[phase] ?? phase;
  return rounds > 1 ? `${words} · round ${round} of ${rounds}` : words;
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
  if (joined.some(({ open, present }) => !open && !present)) return { words: "reconnecting", tone: "attention" };
  const slowest = Math.max(-1, ...joined.filter(({ present }) => present).map(({ rtt_ms }) => rtt_ms));
  if (slowest < 0) return { words: "–", tone: "" };
  return { words: `${Math.round(slowest)} ms`, tone: slowest < 100 ? "ok" : slowest < 250 ? "attention" : "bad" };
}

/** @param {Pick<RoomRow, "phase" | "recording" | "recording_problem">} room @returns {Pill} */
export function recordingPill({ phase, recording, recording_problem }) {
  if (recording_problem) return { words: "not recording", tone: "bad" };
  return recording && (phase === "playing" || phase === "paused")
    ? { words: "recording", tone: "ok" }
    : { words: "–", tone: "" };
}

/** @param {Seat} seat */
export function seatWords({ kind, name, open, present, device }) {
  if (open) return "free seat";
  const who = name || { human: "person", agent: "agent", remote: "program", ghost: "recording", idle: "nobody" }[kind];
  if (!present && (kind === "human" || kind === "remote")) return `${who}, away`;
  return device && kind === "human" ? `${who} · ${device}` : who;
}

/** 184200 -> "184 200", with a narrow space. @param {number} value */
export function grouped(value) {
  return Math.round(value)
    .toString()
    .replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** @param {number} ticks */
function clock(ticks) {
  return clockText(Math.floor(secondsOf(ticks)));
}

/** "2 h 5 min". @param {number} seconds */
export function uptime(seconds) {
  const minutes = Math.floor(seconds / 60);
  if (minutes < 60) return `${minutes} min`;
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** @param {AdminState} state */
export function summaryWords({ rooms, uptime_s }) {
  const people = rooms.flatMap(({ seats }) => seats).filter(({ kind, present }) => kind === "human" && present).length;
  return `${plural(rooms.length, "room")} · ${plural(people, "player")} · up for ${uptime(uptime_s)}`;
}

/** The cards above the rooms. @param {AdminState} state @returns {Fact[]} */
export function facts(state) {
  const { late_ms, missed_ticks, ticks, cpu_percent, disk_free_mb } = state;
  return [
    {
      title: "Late ticks (p99)",
      value: `${late_ms.p99.toFixed(1)} ms`,
      detail: `p50 ${late_ms.p50.toFixed(1)} ms · ${grouped(missed_ticks)} missed of ${grouped(ticks)}`,
      tone: late_ms.p99 > LATE_MS || missed_ticks > 0 ? "bad" : "",
    },
    {
      title: "Connections",
      value: String(state.sockets),
      detail:
        state.deadline_misses === 1 ? "1 late agent answer" : `${grouped(state.deadline_misses)} late agent answers`,
      tone: "",
    },
    {
      title: "Processor",
      value: `${Math.round(cpu_percent)} %`,
      detail: `of one core · ${Math.round(state.rss_mb)} MB memory`,
      tone: cpu_percent > CPU_PERCENT ? "bad" : "",
    },
    {
      title: "Disk",
      value: `${diskWords(disk_free_mb)} free`,
      detail:
        state.finalising > 0 ? `${plural(state.finalising, "recording")} being finished` : "all recordings finished",
      tone: disk_free_mb < DISK_MB ? "bad" : "",
    },
  ];
}

/** @param {number} megabytes */
function diskWords(megabytes) {
  return megabytes < 10_000 ? `${grouped(megabytes)} MB` : `${grouped(megabytes / 1000)} GB`;
}

/** @param {number} count @param {string} noun */
function plural(count, noun) {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}
