// @ts-check
/*
 * A running study in words for the experimenter: from GET /api/experimenter/state to short texts. Partners are
 * letters here too: whoever leads the session stays blind.
 */

import { freeDisk, isLate, milliseconds, missesMany, NO_PILL, roundTripPill } from "../components/dashboard.js";
import { clockText, secondsOf } from "../core/ticks.js";
import { currentLanguage, has, say } from "../text/catalogue.js";
import { mapTitle } from "../text/names.js";

/** @typedef {import("../components/dashboard.js").Pill} Pill */
/** @typedef {import("../components/dashboard.js").Fact} Fact */
/**
 * @typedef {object} ParticipantRow
 * @property {string} pid
 * @property {number | null} unit
 * @property {string | null} partner_letter
 * @property {string | null} partner_pid the other one of a pair
 * @property {number | null} seat
 * @property {string} step
 * @property {string} kind
 * @property {string} [map] by name, and its title
 * @property {string} [title]
 * @property {{done: number, total: number}} position
 * @property {{number: number, of: number} | null} [round]
 * @property {number} since_s
 * @property {boolean} present
 * @property {number} rtt_ms -1: not known
 * @property {string | null} room
 * @property {string} [phase] of the room
 * @property {number | null} tick
 * @property {number | null} [limit_ticks]
 * @property {number | null} late_ms
 * @property {number | null} missed
 * @property {string} recording "recording", "", or what is wrong, in English
 * @property {string | null} outcome
 * @property {boolean} [kept] false: they asked for the deletion of their data
 * @property {boolean} code_given
 * @property {string | null} [code]
 * @property {number | null} [minutes] from arrival to the end
 * @property {string} [episode] of the newest round
 * @property {{episode: string, number: number, map: string, title: string, valid: boolean} | null} [last_round] the
 *   newest one that has ended
 * @property {boolean} [device_bound] whether they may come back in their own browser only
 * @property {boolean} [paused] by the experimenter, alone or with everybody
 * @property {boolean} [unit_paused] by the experimenter, they alone
 * @property {string[]} [waits_for] of the players of a running round, whose connection is lost
 * @property {number | null} [paused_s] since when they stand still, whoever paused
 */
/**
 * @typedef {object} Alert
 * @property {number} id
 * @property {number} at seconds since the epoch
 * @property {string} about its code
 * @property {string} text in English
 * @property {Record<string, unknown>} values
 * @property {string} detail technical, not translated
 */
/** @typedef {{at: number, text: string, pid?: string | null}} Note */
/**
 * @typedef {object} StudyState
 * @property {{id: string, title: string, titles?: Record<string, string>}} study
 * @property {boolean} paused
 * @property {{planned: number, finished: number, group: number, active: number, waiting: number}} counts planned and
 *   finished: participants, or pairs where the group is 2
 * @property {ParticipantRow[]} participants
 * @property {Alert[]} alerts
 * @property {Note[]} notes
 * @property {ServerStatus} server
 */
/**
 * @typedef {object} ServerStatus
 * @property {number} late_p99_ms
 * @property {number} missed deadlines
 * @property {number} ticks
 * @property {number} disk_free_mb
 * @property {number} recordings
 * @property {number} partial recordings that broke off
 */
/**
 * @typedef {"restart-round" | "invalid" | "valid" | "kick" | "note" | "pause" | "resume" | "allow-device"} ActionName
 */

/** @param {StudyState} state */
export function summaryWords({ counts: { finished, planned, group, active, waiting } }) {
  const done = say(group === 2 ? "experimenter.pairsOf" : "experimenter.finishedOf", { finished, planned });
  const parts = [done, say("experimenter.here", { count: active })];
  if (waiting > 0) parts.push(say("experimenter.waitingForPartner", { count: waiting }));
  return parts.join(" · ");
}

/** The text of a name; the name itself where this page does not know it. @param {string} group @param {string} name */
function nameOf(group, name) {
  const key = `experimenter.${group}.${name}`;
  return has(key) ? say(key) : name;
}

/** An alert in the reader's language; the server's own words where this page does not know it. @param {Alert} alert */
export function alertWords({ about, text, values }) {
  const key = `alert.${about}`;
  if (!has(key)) return text;
  const { controls } = values;
  return say(key, Array.isArray(controls) ? { ...values, controls: controls.map(controlName) } : values);
}

/** @param {string} control */
function controlName(control) {
  return has(`study.check.${control}`) ? say(`study.check.${control}`) : control;
}

/** Where somebody is: "Round 8 of 12", "Questions, Partner B". @param {ParticipantRow} row */
export function whereWords({ kind, round, outcome, kept, partner_letter: letter }) {
  const ended = kept === false ? "experimenter.finishedAsDeleted" : "experimenter.finishedAs";
  if (outcome) return say(ended, { outcome: nameOf("outcome", outcome) });
  const step = nameOf("step", kind);
  if (kind === "round" && round) return say("experimenter.round", round);
  return kind === "questionnaire" && letter ? say("experimenter.aboutPartner", { step, letter }) : step;
}

/** "paused 1:12", also between rounds; none where nothing stands still. @param {ParticipantRow} row @returns {Pill} */
export function pausePill(row) {
  const { paused, paused_s: seconds, outcome, phase } = row;
  if (outcome || (!paused && phase !== "paused")) return NO_PILL;
  const key = paused ? "experimenter.paused" : whyPaused(row);
  return { words: say(key, { time: clockText(seconds ?? 0) }), tone: "attention" };
}

/** @param {ParticipantRow} row of somebody whose round stands still, whom the experimenter has not paused */
function whyPaused({ pid, waits_for: away = [] }) {
  if (away.length === 0) return "experimenter.pausedByPlayer";
  return away.includes(pid) ? "experimenter.connectionLost" : "experimenter.waitsForPartner";
}

/** What somebody is to be paid for: "K7QX4WPL2M · 61.6 min"; empty before the end. @param {ParticipantRow} row */
export function codeWords({ outcome, code, minutes }) {
  if (!outcome || !code) return "";
  const shown = (minutes ?? 0).toLocaleString(currentLanguage(), { maximumFractionDigits: 1 });
  return say("experimenter.codeAndMinutes", { code, minutes: shown });
}

export const GROUPS = /** @type {const} */ (["all", "playing", "paused", "away", "waiting", "finished"]);
/** @typedef {typeof GROUPS[number]} Group */

/** Whether somebody is to be seen under a filter. @param {ParticipantRow} row @param {Group} group */
export function isIn(row, group) {
  const here = !row.outcome;
  return {
    all: true,
    playing: here && row.room !== null,
    paused: here && pausePill(row) !== NO_PILL,
    away: here && !row.present,
    waiting: here && row.kind === "waiting",
    finished: !here,
  }[group];
}

/**
 * Blue and red with who sits there; null outside of rounds.
 * @param {ParticipantRow} row
 * @returns {[string, string] | null}
 */
export function seatNames({ pid, seat, partner_letter, partner_pid, outcome, kind }) {
  if (outcome || seat === null || !["round", "practice"].includes(kind)) return null;
  const letter = partner_letter ? say("experimenter.partnerLetter", { letter: partner_letter }) : "";
  const partner = partner_pid ?? (letter || say("experimenter.partner"));
  return seat === 0 ? [pid, partner] : [partner, pid];
}

/** The time played of a running round, else how long somebody has been at this step. @param {ParticipantRow} row */
export function timeWords({ tick, limit_ticks, since_s, outcome, phase }) {
  if (outcome) return "";
  if (tick === null || tick === undefined || tick === 0) return clockText(since_s);
  const played = limit_ticks
    ? `${clockText(secondsOf(tick))} / ${clockText(secondsOf(limit_ticks))}`
    : clockText(secondsOf(tick));
  return phase === "paused" ? say("experimenter.pausedAt", { time: played }) : played;
}

/** @param {ParticipantRow} row @returns {Pill} */
export function linkPill({ present, rtt_ms, outcome }) {
  if (outcome) return NO_PILL;
  if (!present) return { words: say("experimenter.away"), tone: "attention" };
  return rtt_ms < 0 ? { words: say("experimenter.present"), tone: "ok" } : roundTripPill(rtt_ms);
}

/** @param {ParticipantRow} row @returns {Pill} */
export function tickPill({ late_ms, missed, outcome }) {
  if (outcome || late_ms === null || late_ms === undefined) return NO_PILL;
  if (missed) return { words: say("experimenter.missed", { count: missed }), tone: "bad" };
  return {
    words: say("experimenter.late", { time: milliseconds(late_ms, 1) }),
    tone: isLate(late_ms) ? "attention" : "ok",
  };
}

/** @param {ParticipantRow} row @returns {Pill} */
export function recordingPill({ recording }) {
  if (!recording) return NO_PILL;
  return recording === "recording"
    ? { words: say("dashboard.recording"), tone: "ok" }
    : { words: say("admin.notRecording"), tone: "bad" };
}

/** The cards above the table. @param {StudyState} state @returns {Fact[]} */
export function facts({ counts: { finished, planned, group }, server }) {
  const left = Math.max(0, planned - finished);
  const { missed, ticks, partial } = server;
  const disk = freeDisk(server.disk_free_mb);
  return [
    {
      title: say(group === 2 ? "experimenter.pairs" : "experimenter.finished"),
      value: say("experimenter.of", { finished, planned }),
      detail: left === 0 ? say("experimenter.asPlanned") : say("experimenter.toCome", { count: left }),
      tone: "",
    },
    {
      title: say("dashboard.lateTicks"),
      value: milliseconds(server.late_p99_ms, 1),
      detail: say("dashboard.missedOf", { missed, ticks }),
      tone: isLate(server.late_p99_ms) || missesMany(missed, ticks) ? "bad" : "",
    },
    {
      title: say("dashboard.recordings"),
      value: server.recordings.toLocaleString(currentLanguage()),
      detail: partial === 0 ? say("experimenter.allComplete") : say("experimenter.partial", { count: partial }),
      tone: "",
    },
    { title: say("dashboard.disk"), value: disk.value, detail: say("experimenter.free"), tone: disk.tone },
  ];
}

/**
 * The reader's clock, "14:05"; of another day with its date.
 * @param {number} seconds since the epoch
 * @param {Date} [now]
 */
export function atWords(seconds, now = new Date()) {
  const at = new Date(seconds * 1000);
  const clock = at.toLocaleTimeString(currentLanguage(), { hour: "2-digit", minute: "2-digit" });
  if (at.toDateString() === now.toDateString()) return clock;
  return `${at.toLocaleDateString(currentLanguage(), { day: "numeric", month: "short", year: "numeric" })}, ${clock}`;
}

/**
 * Whoever needs attention first: away, then here, then finished; each in order of arrival.
 * @param {readonly ParticipantRow[]} rows
 */
export function sorted(rows) {
  const rank = (/** @type {ParticipantRow} */ row) => (row.outcome ? 2 : row.present ? 1 : 0);
  return rows
    .map((row, index) => ({ row, index }))
    .sort((a, b) => rank(a.row) - rank(b.row) || a.index - b.index)
    .map(({ row }) => row);
}

/** The actions that ask for a reason, which is kept with the data. */
const ASKS = ["restart-round", "invalid", "valid", "note", "kick"];

/** Those of them that end a running round. */
const HOLDS = ["restart-round", "kick"];

/** Those that are about the last round, which they name. */
const MARKS = ["invalid", "valid"];

/** @param {ActionName} action @param {NonNullable<ParticipantRow["last_round"]>} last */
function markWords(action, { number, map, title }) {
  return say(`experimenter.action.${action}.round`, { number, map: mapTitle({ name: map, title }) });
}

/**
 * What can be done for somebody now; `asks` is the question for the reason, or empty; `holds`: their round stands still
 * while it is asked.
 * @param {ParticipantRow} row
 * @returns {{action: ActionName, label: string, asks: string, danger: boolean, holds: boolean}[]}
 */
export function actionsFor({ outcome, kind, last_round: last, room, unit, paused, device_bound: deviceBound }) {
  const inRound = ["round", "practice"].includes(kind) && room !== null && !outcome;
  /** @type {ActionName[]} */
  const actions = [];
  if (!outcome && unit !== null) actions.push(paused ? "resume" : "pause");
  if (inRound) actions.push("restart-round");
  if (last) actions.push(last.valid ? "invalid" : "valid");
  actions.push("note");
  if (deviceBound && !outcome) actions.push("allow-device");
  if (!outcome) actions.push("kick");
  return actions.map((action) => ({
    action,
    label: last && MARKS.includes(action) ? markWords(action, last) : say(`experimenter.action.${action}`),
    asks: ASKS.includes(action) ? say(`experimenter.reason.${action}`) : "",
    danger: action === "kick",
    holds: inRound && HOLDS.includes(action),
  }));
}

const NOTED = /^(restart-round|invalid|valid|kick): /; // what the server puts before the reason of an action

/** A note; the reason of an action stands behind its name. @param {string} text */
export function noteWords(text) {
  return text.replace(NOTED, (_, action) => `${say(`experimenter.action.${action}`)}: `);
}
