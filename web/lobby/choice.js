// @ts-check
/*
 * What can be chosen in the lobby, and the request that a choice becomes. Pure: knows neither page nor network.
 */

import { ticksOf } from "../core/ticks.js";
import { LIMIT_TICKS } from "../messages.js";

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
/** @typedef {{kind: "here" | "link" | "agent" | "remote", agent?: string}} SeatRequest */
/**
 * @typedef {object} Choice
 * @property {string} map the map's name
 * @property {[string, string]} seats values of the seat options: "here", "link", "remote" or "agent:<id>"
 * @property {number} limitTicks
 * @property {number | null} seed Challenge 2, null for the maps as they are
 */

/** Limits to choose from in ticks, with what people read; 50 s is the paper's (section "Human Study Procedure"). */
export const LIMITS = [
  { ticks: ticksOf(30), label: "30 s" },
  { ticks: LIMIT_TICKS, label: "50 s" },
  { ticks: ticksOf(90), label: "90 s" },
  { ticks: ticksOf(180), label: "3 min" },
  { ticks: ticksOf(300), label: "5 min" },
];
export const SEED_MAX = 999_999_999;

/** Modes in the paper's order with what each asks of two players. */
export const MODES = /** @type {const} */ ([
  { id: "coordination", title: "Coordination", help: "Share the work and stay out of each other's way." },
  { id: "awareness", title: "Awareness", help: "Notice when your partner needs you." },
  { id: "action consistency", title: "Action consistency", help: "Move large things as one." },
]);

/**
 * Everything that may sit on a seat.
 * @param {readonly AgentCard[]} agents
 * @returns {SeatOption[]}
 */
export function seatOptions(agents) {
  return [
    { value: "here", label: "Me, at this computer", help: "With keyboard, gamepad or touch.", group: "People" },
    { value: "link", label: "A person, by link", help: "You get a link and a code for them.", group: "People" },
    ...agents.map((agent) => ({
      value: `agent:${agent.id}`,
      label: agent.name || agent.id,
      help: agentLine(agent),
      group: "Agents",
    })),
    { value: "remote", label: "A program", help: "Your own program joins over the network.", group: "Other" },
  ];
}

/** What trained policies are called. @type {Record<string, string>} */
const POLICIES = { mlp: "MLP", gru: "GRU", dp: "Diffusion Policy" };

/**
 * An agent in one line: of a trained one what it is, whom it has learned from and how much it delivers with people it
 * never met; of another the first sentence of its description.
 * @param {AgentCard} agent
 */
export function agentLine({ kind, policy, population, tcr, description }) {
  const name = POLICIES[policy ?? ""];
  if (!name || !population) return firstSentence(description);
  const what = `${name}${kind === "bass" ? " with BASS" : ""}, learned from ${population.split(";")[0]}.`;
  return typeof tcr?.unseen === "number" ? `${what} ${tcrWords(tcr.unseen, tcr.alone)}` : what;
}

/** @param {number} unseen @param {number | null} alone */
function tcrWords(unseen, alone) {
  const beside = typeof alone === "number" ? ` (${alone.toFixed(2)} without help)` : "";
  return `TCR ${unseen.toFixed(2)} with scripted people it never met${beside}.`;
}

/** A lobby has room for one line. @param {string} text */
function firstSentence(text) {
  return text.split(/(?<=[.!?]) /)[0];
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

/** @param {string} value @returns {SeatRequest} */
export function seatRequest(value) {
  if (value.startsWith("agent:")) return { kind: "agent", agent: value.slice("agent:".length) };
  if (value === "here" || value === "link" || value === "remote") return { kind: value };
  throw new RangeError(`no such seat: ${value}`);
}

/**
 * The body of POST /api/rooms.
 * @param {Choice} choice
 * @param {readonly string[]} maps the rounds in order
 * @param {boolean} [practice]
 */
export function roomRequest(choice, maps, practice = false) {
  return {
    maps: [...maps],
    limit_ticks: practice ? 0 : choice.limitTicks,
    practice,
    challenge2_seed: practice ? null : choice.seed,
    seats: choice.seats.map(seatRequest),
  };
}

/**
 * What the two seats together mean, in one sentence; empty when it is plain.
 * @param {readonly [string, string]} seats
 */
export function seatsNote(seats) {
  const [blue, red] = seats;
  if (blue === "here" && red === "here") {
    const keys = "blue on W A S D with space and red on the arrow keys with Enter";
    return `Two people at this screen: two gamepads, or ${keys}.`;
  }
  if (!seats.includes("here")) {
    return seats.some(isOpen) ? "You do not play yourself: you get the links." : "You do not play yourself: you watch.";
  }
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
