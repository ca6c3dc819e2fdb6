// @ts-check
/*
 * A running study in words for the experimenter. Pure: from GET /api/experimenter/state to short texts. Partners are
 * letters here too: whoever leads the session stays blind.
 */

import { clockText, secondsOf } from "../core/ticks.js";

/** @typedef {"" | "ok" | "attention" | "bad"} Tone */
/** @typedef {{words: string, tone: Tone}} Pill */
/**
 * @typedef {object} ParticipantRow
 * @property {string} pid
 * @property {number | null} unit
 * @property {string | null} partner_letter
 * @property {string | null} partner_pid the other one of a pair
 * @property {number | null} seat
 * @property {string} step
 * @property {string} kind
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
 * @property {string} recording "recording", "", or what is wrong
 * @property {string | null} outcome
 * @property {boolean} code_given
 * @property {string} [episode] of the newest round
 * @property {boolean} [paused]
 */
/** @typedef {{id: number, at: number, text: string}} Alert at: seconds since the epoch */
/** @typedef {{at: number, text: string, pid?: string | null}} Note */
/**
 * @typedef {object} StudyState
 * @property {{id: string, title: string}} study
 * @property {boolean} paused
 * @property {{planned: number, finished: number, active: number, waiting: number}} counts
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
/** @typedef {"restart-round" | "invalid" | "kick" | "note" | "pause" | "resume"} ActionName */
/** @typedef {{title: string, value: string, detail: string, tone: "" | "bad"}} Fact */

const LATE_MS = 5; // p99 beyond which a person might notice
const DISK_MB = 1000;

const KINDS = /** @type {Record<string, string>} */ ({
  consent: "Consent",
  form: "About them",
  questionnaire: "Questions",
  "input-check": "Trying the controls",
  practice: "Practice",
  round: "Round",
  waiting: "Waiting for a partner",
  break: "Break",
  debrief: "Debrief",
  code: "Finished",
  paused: "Paused",
});
const OUTCOMES = /** @type {Record<string, string>} */ ({
  done: "done",
  "partner-left": "partner left",
  "no-partner": "no partner came",
  withdrew: "withdrew",
  "screened-out": "screened out",
  declined: "declined",
});

/** @param {StudyState} state */
export function summaryWords({ counts }) {
  const parts = [`${counts.finished} of ${counts.planned} finished`, `${counts.active} here`];
  if (counts.waiting > 0) parts.push(`${counts.waiting} waiting for a partner`);
  return parts.join(" · ");
}

/** Where somebody is: "Round 8 of 12", "Questions, Partner B". @param {ParticipantRow} row */
export function whereWords({ kind, round, outcome, partner_letter }) {
  if (outcome) return `Finished · ${OUTCOMES[outcome] ?? outcome}`;
  const words = KINDS[kind] ?? kind;
  if (kind === "round" && round) return `Round ${round.number} of ${round.of}`;
  return kind === "questionnaire" && partner_letter ? `${words}, Partner ${partner_letter}` : words;
}

/**
 * Blue and red with who sits there; null outside of rounds.
 * @param {ParticipantRow} row
 * @returns {[string, string] | null}
 */
export function seatNames({ pid, seat, partner_letter, partner_pid, outcome, kind }) {
  if (outcome || seat === null || !["round", "practice"].includes(kind)) return null;
  const partner = partner_pid ?? (partner_letter ? `Partner ${partner_letter}` : "partner");
  return seat === 0 ? [pid, partner] : [partner, pid];
}

/** Of a running round the time played, else how long somebody is at this step. @param {ParticipantRow} row */
export function timeWords({ tick, limit_ticks, since_s, outcome, phase }) {
  if (outcome) return "";
  if (tick === null || tick === undefined || tick === 0) return clockText(since_s);
  const played = limit_ticks
    ? `${clockText(secondsOf(tick))} / ${clockText(secondsOf(limit_ticks))}`
    : clockText(secondsOf(tick));
  return phase === "paused" ? `${played}, paused` : played;
}

/** @param {ParticipantRow} row @returns {Pill} */
export function linkPill({ present, rtt_ms, outcome }) {
  if (outcome) return { words: "–", tone: "" };
  if (!present) return { words: "away", tone: "attention" };
  if (rtt_ms < 0) return { words: "here", tone: "ok" };
  return { words: `${Math.round(rtt_ms)} ms`, tone: rtt_ms < 100 ? "ok" : rtt_ms < 250 ? "attention" : "bad" };
}

/** @param {ParticipantRow} row @returns {Pill} */
export function tickPill({ late_ms, missed, outcome }) {
  if (outcome || late_ms === null || late_ms === undefined) return { words: "–", tone: "" };
  if (missed) return { words: `${missed} missed`, tone: "bad" };
  return { words: `${late_ms.toFixed(1)} ms late`, tone: late_ms > LATE_MS ? "attention" : "ok" };
}

/** @param {ParticipantRow} row @returns {Pill} */
export function recordingPill({ recording }) {
  if (!recording) return { words: "–", tone: "" };
  return recording === "recording" ? { words: "recording", tone: "ok" } : { words: recording, tone: "bad" };
}

/** The cards above the table. @param {StudyState} state @returns {Fact[]} */
export function facts({ counts, server }) {
  const left = Math.max(0, counts.planned - counts.finished);
  return [
    {
      title: "Finished",
      value: `${counts.finished} of ${counts.planned}`,
      detail: left === 0 ? "as many as planned" : `${left} to come`,
      tone: "",
    },
    {
      title: "Late ticks (p99)",
      value: `${server.late_p99_ms.toFixed(1)} ms`,
      detail: `${grouped(server.missed)} missed of ${grouped(server.ticks)}`,
      tone: server.late_p99_ms > LATE_MS || server.missed > 0 ? "bad" : "",
    },
    {
      title: "Recordings",
      value: grouped(server.recordings),
      detail: server.partial === 0 ? "all complete" : `${grouped(server.partial)} partial`,
      tone: "",
    },
    {
      title: "Disk",
      value:
        server.disk_free_mb < 10_000
          ? `${grouped(server.disk_free_mb)} MB`
          : `${grouped(server.disk_free_mb / 1000)} GB`,
      detail: "free",
      tone: server.disk_free_mb < DISK_MB ? "bad" : "",
    },
  ];
}

/** 184200 -> "184 200", with a narrow space. @param {number} value */
function grouped(value) {
  return Math.round(value)
    .toString()
    .replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** The reader's clock, "14:05". @param {number} seconds since the epoch */
export function atWords(seconds) {
  return new Date(seconds * 1000).toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
}

/**
 * Those who need somebody first: away, then here, then finished; each by when they came.
 * @param {readonly ParticipantRow[]} rows
 */
export function sorted(rows) {
  const rank = (/** @type {ParticipantRow} */ row) => (row.outcome ? 2 : row.present ? 1 : 0);
  return rows
    .map((row, index) => ({ row, index }))
    .sort((a, b) => rank(a.row) - rank(b.row) || a.index - b.index)
    .map(({ row }) => row);
}

/**
 * What can be done for somebody now.
 * @param {ParticipantRow} row
 * @returns {{action: ActionName, label: string, asks: string, danger: boolean}[]}
 */
export function actionsFor({ outcome, kind, episode, room, unit, paused }) {
  /** @type {ReturnType<typeof actionsFor>} */
  const actions = [];
  const playing = ["round", "practice"].includes(kind) && room !== null && !outcome;
  if (!outcome && unit !== null) {
    if (paused) actions.push({ action: "resume", label: "Go on", asks: "", danger: false });
    else actions.push({ action: "pause", label: "Pause", asks: "", danger: false });
  }
  if (playing)
    actions.push({ action: "restart-round", label: "Restart the round", asks: "Why it is restarted", danger: false });
  if (episode)
    actions.push({
      action: "invalid",
      label: "Mark the last round invalid",
      asks: "Why it does not count",
      danger: false,
    });
  actions.push({ action: "note", label: "Add a note", asks: "What happened", danger: false });
  if (!outcome)
    actions.push({ action: "kick", label: "End the study for them", asks: "Why they have to leave", danger: true });
  return actions;
}
