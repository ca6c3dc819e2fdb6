// @ts-check
/*
 * What can be chosen in the lobby, and the request that a choice becomes. Knows neither page nor network.
 */

import { lastingStorage } from "../core/browser_storage.js";
import { secondsOf, ticksOf } from "../core/ticks.js";
import { keyName, loadMapping, moveName } from "../input/mapping.js";
import { LIMIT_TICKS } from "../messages.js";
import { say } from "../text/catalogue.js";
import { partnerLine, partnerName } from "./partners.js";

/**
 * @typedef {object} AgentCard what the server says of an agent
 * @property {string} id
 * @property {string} name
 * @property {string} description
 * @property {string} [kind] mlp, gru, dp or bass where it is trained
 * @property {string} [policy] of a trained one: mlp, gru or dp
 * @property {string} [population] whose play it has learned from; empty where it has not
 * @property {{unseen: number | null, alone: number | null}} [tcr] measured with people it never met, and of these
 *   people beside a partner who stands still
 */
/** @typedef {{value: string, label: string, help: string, group: string}} SeatOption */
/** @typedef {{kind: "here" | "link" | "agent" | "partner" | "remote", agent?: string}} SeatRequest */
/**
 * @typedef {object} Choice
 * @property {string} map its card: the name, or what extra_map.js calls the map just played
 * @property {[string, string]} seats values of the seat options: "here", "link", "remote" or "agent:<id>"
 * @property {number} limitTicks
 * @property {number | null} seed Challenge 2, null for the maps as they are
 */

/** Limits to choose from, in ticks; 50 s is the paper's (section "Human Study Procedure"). */
export const LIMITS = [ticksOf(30), LIMIT_TICKS, ticksOf(90), ticksOf(180), ticksOf(300)];

/** Where whoever comes for the first time starts: nothing in the way, light and middle items. */
export const FIRST_MAP = "DistancePriority";

/** The modes of maps in the paper's order. */
export const MODES = /** @type {const} */ (["coordination", "awareness", "action consistency"]);

/** The catalogue key of a mode: "mode.action-consistency". @param {string} mode */
export function modeKey(mode) {
  return `mode.${mode.replace(" ", "-")}`;
}

/** "90 s", "3 min". @param {number} ticks */
export function limitText(ticks) {
  const seconds = secondsOf(ticks);
  return seconds > 90 ? say("lobby.limit.minutes", { minutes: seconds / 60 }) : say("lobby.limit.seconds", { seconds });
}

/**
 * Everything that may sit on a seat.
 * @param {readonly AgentCard[]} agents
 * @returns {SeatOption[]}
 */
export function seatOptions(agents) {
  const people = say("lobby.group.people");
  return [
    { value: "here", label: say("lobby.seat.here"), help: say("lobby.seat.here.help"), group: people },
    { value: "link", label: say("lobby.seat.link"), help: say("lobby.seat.link.help"), group: people },
    ...agents.map((agent) => ({
      value: `agent:${agent.id}`,
      label: partnerName(agent),
      help: partnerLine(agent),
      group: say("lobby.group.agents"),
    })),
    {
      value: "remote",
      label: say("lobby.seat.remote"),
      help: say("lobby.seat.remote.help"),
      group: say("lobby.group.other"),
    },
  ];
}

/**
 * Who sits opposite a person that comes for the first time: the server's default, else the first agent that moves.
 * @param {readonly AgentCard[]} agents
 * @param {string} [preferred]
 */
export function defaultPartner(agents, preferred) {
  const partner =
    agents.find(({ id }) => id === preferred) ??
    agents.find(({ id }) => id === "scripted") ??
    agents.find(({ id }) => id !== "idle");
  return partner ? `agent:${partner.id}` : "link";
}

/**
 * @param {string} value of a seat option
 * @param {string} [proposed] whom the server proposes: it seats another one where that partner cannot play
 * @returns {SeatRequest}
 */
export function seatRequest(value, proposed) {
  if (value === proposed && value.startsWith("agent:")) return { kind: "partner" };
  if (value.startsWith("agent:")) return { kind: "agent", agent: value.slice("agent:".length) };
  if (value === "here" || value === "link" || value === "remote") return { kind: value };
  throw new RangeError(`no such seat: ${value}`);
}

/**
 * The body of POST /api/rooms.
 * @param {Choice} choice
 * @param {readonly string[]} maps the rounds in order
 * @param {boolean} [practice]
 * @param {string} [proposed] value of the seat option that nobody had to choose
 */
export function roomRequest(choice, maps, practice = false, proposed = undefined) {
  return {
    maps: [...maps],
    limit_ticks: practice ? 0 : choice.limitTicks,
    practice,
    challenge2_seed: practice ? null : choice.seed,
    seats: choice.seats.map((value) => seatRequest(value, proposed)),
  };
}

/**
 * What the two seats together mean, in one sentence; empty when it is plain.
 * @param {readonly [string, string]} seats
 * @param {boolean} [touch] people play here with their fingers, which drive blue
 * @param {Pick<Storage, "getItem">} [storage] with the reader's own keys
 */
export function seatsNote(seats, touch = false, storage = lastingStorage()) {
  const [blue, red] = seats;
  if (blue === "here" && red === "here") {
    const [first, second] = loadMapping(storage).keys;
    return say(touch ? "lobby.note.twoHereTouch" : "lobby.note.twoHere", {
      ...{ move1: moveName(first), grab1: keyName(first.grab) },
      ...{ move2: moveName(second), grab2: keyName(second.grab) },
    });
  }
  if (!seats.includes("here")) return say(seats.some(isOpen) ? "lobby.note.links" : "lobby.note.watch");
  return "";
}

/** Whether somebody or something has still to come by itself. @param {string} value */
export function isOpen(value) {
  return value === "link" || value === "remote";
}

/**
 * The seed that was typed; null when it is none.
 * @param {string} text
 */
export function parseSeed(text) {
  const digits = text.trim();
  return /^\d{1,9}$/.test(digits) ? Number(digits) : null;
}
