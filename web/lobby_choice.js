// @ts-check
/*
 * What can be chosen in the lobby, and the request that a choice becomes. Pure: knows neither page nor network.
 */

/** @typedef {{id: string, name: string, description: string}} AgentCard */
/** @typedef {{value: string, label: string, help: string, group: string}} SeatOption */
/** @typedef {{kind: "here" | "link" | "agent" | "remote", agent?: string}} SeatRequest */
/**
 * @typedef {object} Choice
 * @property {string} map the map's name
 * @property {[string, string]} seats values of the seat options: "here", "link", "remote" or "agent:<id>"
 * @property {number} limitTicks
 * @property {number | null} seed Challenge 2, null for the maps as they are
 */

export const TICKS_PER_S = 10;

/** Limits to choose from in ticks, with what people read; 50 s is the paper's (section "Human Study Procedure"). */
export const LIMITS = /** @type {const} */ ([
  { ticks: 300, label: "30 s" },
  { ticks: 500, label: "50 s" },
  { ticks: 900, label: "90 s" },
  { ticks: 1800, label: "3 min" },
  { ticks: 3000, label: "5 min" },
]);
export const DEFAULT_LIMIT = 500;
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
    ...agents.map(({ id, name, description }) => ({
      value: `agent:${id}`,
      label: name || id,
      help: firstSentence(description),
      group: "Agents",
    })),
    { value: "remote", label: "A program", help: "Your own program joins over the network.", group: "Other" },
  ];
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
    return "Two people at this screen: two gamepads, or blue on W A S D with space and red on the arrow keys with Enter.";
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
