// Short phrases about seats and the connection, from the state of the room and the view. Pure.

import { roundTripTone } from "../core/round_trip.js";
import { clockText } from "../core/ticks.js";
import { has, say } from "../text/catalogue.js";
import { agentName, recordedPlayer, shapeObject } from "../text/names.js";

/** @typedef {import("../messages.js").SeatState} SeatState */
/** @typedef {import("./game.js").GameMap} GameMap */
/** @typedef {import("../view/render.js").View} View */
/** @typedef {import("../wire/connection.js").Status} Status */
/** @typedef {import("../messages.js").RoomState["phase"]} Phase */

const PATIENCE_MS = 1000; // a shorter interruption is not mentioned
const LONG_S = 90; // more than that is told in minutes
/** What is said in another way to whom it is about. @type {Record<string, string>} */
const BY_YOU = { paused: "play.pausedByYou", not_back: "play.awayTooLong", unsteady: "play.lostTooOften" };

/**
 * What to call a seat.
 * @param {SeatState} seat @param {boolean} own @param {boolean} [watching] the reader is a spectator
 */
export function seatName(seat, own, watching = false) {
  if (own) return seat.name || say("play.you");
  if (["agent", "idle"].includes(seat.kind)) return agentName(seat.name || seat.kind);
  if (seat.kind === "ghost" && seat.name) return say("play.ghost.of", { player: recordedPlayer(seat.name) });
  return seat.name || (seat.kind === "human" && !watching ? say("play.partner") : say(`play.kind.${seat.kind}`));
}

/**
 * Whom everybody else still waits for before a round, or who has left after one.
 * @param {SeatState} seat @param {boolean} watching the reader is a spectator @param {Phase} phase
 */
export function waitingForText(seat, watching, phase) {
  const name = toldName(seat, watching);
  if (isOver(phase) && !seat.present) return `${name}: ${waitingWords(seat, phase)}`;
  if (seat.kind === "human" && !seat.name && !watching) return say("play.ready.waitingForPartner");
  return say("play.ready.waitingFor", { name });
}

/**
 * Whoever watches may see two people without a name, who are told apart by their colours.
 * @param {SeatState} seat @param {boolean} watching
 */
function toldName(seat, watching) {
  return watching && isPerson(seat) && !seat.name ? say(`colour.${seat.colour}`) : seatName(seat, false, watching);
}

/** Whether a round or all of them are over. @param {string} phase */
export function isOver(phase) {
  return phase === "round_over" || phase === "series_over";
}

/**
 * What a seat is doing before and between rounds; after the last one, who has left or would play again.
 * @param {SeatState} seat @param {Phase} phase @param {boolean} [own] of this page: whoever reads it is not away
 */
export function waitingWords(seat, phase, own = false) {
  if (phase === "series_over" && (!isPerson(seat) || (seat.present && !seat.ready))) return "";
  if (seat.open || (!seat.present && seat.kind !== "idle"))
    return say(isOver(phase) ? "play.state.left" : "play.state.notHere");
  if (seat.kind === "idle") return say("play.state.idle");
  const away = seat.visible === false && !own; // a node of an earlier version does not say it
  if (seat.ready) return say(away ? "play.state.readyAway" : "play.state.ready");
  return say(away ? "play.state.away" : "play.state.notReady");
}

/** Whether somebody plays who may come and go. @param {SeatState} seat */
function isPerson({ kind }) {
  return kind === "human" || kind === "remote";
}

/**
 * Why no further round begins, although everybody may be ready; empty where one does.
 * @param {Partial<import("../messages.js").RoomState> | null} room
 */
export function heldText(room) {
  return room?.reason_code === "restart_soon" ? say("reason.restart_soon") : "";
}

/**
 * Which of the other people are here and ready before or after a round: "Partner: ready"; or why they wait in vain.
 * @param {Pick<import("../messages.js").RoomState, "phase" | "seats"> &
 *   Partial<import("../messages.js").RoomState> | null} room
 * @param {readonly number[]} own
 */
export function companyText(room, own) {
  const held = heldText(room);
  if (held) return held;
  const phase = room?.phase ?? "lobby";
  return (room?.seats ?? [])
    .filter((seat, index) => !own.includes(index) && isPerson(seat) && waitingWords(seat, phase) !== "")
    .map((seat) => `${toldName(seat, own.length === 0)}: ${waitingWords(seat, phase)}`)
    .join(". ");
}

/**
 * What a seat is doing in the game.
 * @param {SeatState} seat @param {number} index 0 blue, 1 red @param {GameMap} map @param {View} view
 * @param {readonly number[]} own seats of this page
 */
export function playingWords(seat, index, map, view, own) {
  if (!seat.present && seat.kind !== "idle") return say("play.state.gone");
  if (seat.visible === false && !own.includes(index)) return say("play.state.away");
  const held = view.held[index];
  if (held < 0) return seat.kind === "idle" ? say("play.state.idle") : say("play.state.free");
  const item = map.items[held];
  const state = (/** @type {string} */ name) => say(`play.state.${name}`, { item: shapeObject(item.shape) });
  if (view.held[1 - index] === held) return state("together");
  if (item.size === "small") return state("carrying");
  if (item.size === "middle") return state("slow");
  if (own.includes(index)) return state("blocked");
  return own.length > 0 ? say("play.state.help") : say("play.state.helpPartner");
}

/** @param {{index: number, total: number}} round */
export function roundText({ index, total }) {
  return total > 1 ? say("play.round", { number: index + 1, total }) : say("play.oneRound");
}

/** The one sentence that says what to do on this map. @param {GameMap} map @param {boolean} [watching] a spectator */
export function taskSentence(map, watching = false) {
  const sizes = new Set(map.items.map((item) => item.size));
  const heaviest = sizes.has("large") ? "large" : sizes.has("middle") ? "middle" : "small";
  const values = { count: map.goals.length };
  return watching ? say(`play.taskWatched.${heaviest}`, values) : say(`play.task.${heaviest}`, values);
}

/**
 * The connection as a word and a colour.
 * @param {import("../wire/connection.js").Status} status @param {boolean} stalled @param {number} rttMs -1 unknown
 * @returns {{words: string, state: "ok" | "attention" | "bad" | ""}}
 */
export function connectionWords(status, stalled, rttMs) {
  if (status === "connecting") return { words: say("play.quality.waiting"), state: "" };
  if (status === "over") return { words: say("play.quality.over"), state: "" }; // the page says why
  if (status !== "open") return { words: say("play.quality.lost"), state: "bad" };
  if (stalled) return { words: say("play.quality.stalled"), state: "bad" };
  if (rttMs < 0) return { words: say("play.quality.waiting"), state: "" };
  const shown = Math.max(1, Math.round(rttMs));
  const state = roundTripTone(rttMs);
  const key = /** @type {const} */ ({ ok: "good", attention: "fair", bad: "poor" })[state];
  return { words: say(`play.quality.${key}`, { ms: shown }), state };
}

/**
 * Why the game waits or is over.
 * @param {Pick<import("../messages.js").RoomState, "reason" | "reason_code" | "reason_values"> &
 *   Partial<Pick<import("../messages.js").RoomState, "seats">> | null} room
 * @param {readonly number[]} own seats of this page: its only player is told that it was they
 */
export function reasonText(room, own = []) {
  if (room === null) return "";
  const { reason, reason_code: code, reason_values: values } = room;
  const mine = own.length === 1 ? room.seats?.[own[0]] : undefined;
  const players = Array.isArray(values.players) ? values.players : [];
  if (mine && code in BY_YOU && players.length === 1 && players[0] === (mine.name || mine.colour))
    return say(BY_YOU[code]);
  return has(`reason.${code}`) ? say(`reason.${code}`, withNames(values)) : reason;
}

/**
 * How long a pause lasts at most, where somebody waits: for who has to come back, and for who has paused a game of two
 * people. The experimenter's pause says nothing: its limit is a day, and nobody's time to come back runs in it.
 * @param {Pick<import("../messages.js").RoomState, "reason_code" | "seats"> | null} room @param {number} seconds
 */
export function pauseLimitText(room, seconds) {
  if (room === null || room.reason_code === "study_paused") return "";
  const time =
    seconds > LONG_S
      ? say("play.pause.minutes", { clock: clockText(seconds) })
      : say("play.pause.seconds", { count: seconds });
  const players = room.seats.filter(({ present }) => !present).map(({ name, colour }) => name || colour);
  if (players.length > 0) return say("play.pause.back", withNames({ players, time }));
  const people = room.seats.filter(({ kind }) => kind === "human" || kind === "remote");
  const someWait = room.reason_code === "paused" && people.length > 1 && people.some(({ ready }) => ready);
  return someWait ? say("play.pause.most", { time }) : "";
}

/** A refusal over the socket. @param {{code: string, message: string, values: Record<string, any>}} refusal */
export function refusalText({ code, message, values }) {
  return has(`error.${code}`) ? say(`error.${code}`, withNames(values)) : message;
}

/**
 * The players among the values by the names that this page gives them ("blue" for a seat without one, an agent's id),
 * and as `count` how many they are.
 * @param {Record<string, any>} values
 */
function withNames(values) {
  if (!Array.isArray(values.players)) return values;
  const named = (/** @type {string} */ player) =>
    has(`colour.${player}`) ? say(`colour.${player}`) : agentName(player);
  return { ...values, players: values.players.map(named), count: values.players.length };
}

/**
 * What to say about a lost connection; empty during a short interruption.
 * @param {Status} status
 * @param {number} forMs how long it has had this status
 * @param {string} [why] what the server said, a sentence
 */
export function lostText(status, forMs, why = "") {
  if (forMs < PATIENCE_MS) return "";
  if (status === "connecting") return say("play.connecting");
  return status === "reconnecting" ? why || say("play.reconnecting") : "";
}
