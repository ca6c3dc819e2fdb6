// What the seats are doing, in words for people. Pure: from the room and the view to short phrases.

import { TEXT } from "../text/text.js";

/** @typedef {import("../messages.js").SeatState} SeatState */
/** @typedef {import("./game.js").GameMap} GameMap */
/** @typedef {import("../view/render.js").View} View */

/**
 * What to call a seat.
 * @param {SeatState} seat @param {boolean} own @param {boolean} [watching] who reads this plays with nobody
 */
export function seatName(seat, own, watching = false) {
  if (own) return seat.name || TEXT.you;
  if (seat.kind === "agent" && /^[a-z]+$/.test(seat.name)) return seat.name[0].toUpperCase() + seat.name.slice(1);
  return seat.name || (seat.kind === "human" && !watching ? TEXT.partner : TEXT.kinds[seat.kind]);
}

/** What a seat does before and between rounds. @param {SeatState} seat */
export function waitingWords(seat) {
  if (seat.open || (!seat.present && seat.kind !== "idle")) return TEXT.state.notHere;
  if (seat.kind === "idle") return TEXT.state.idle;
  return seat.ready ? TEXT.state.ready : TEXT.state.notReady;
}

/**
 * What a seat does in the game.
 * @param {SeatState} seat @param {number} index 0 blue, 1 red @param {GameMap} map @param {View} view
 * @param {readonly number[]} own seats of this page
 */
export function playingWords(seat, index, map, view, own) {
  if (!seat.present && seat.kind !== "idle") return TEXT.state.gone;
  const held = view.held[index];
  if (held < 0) return seat.kind === "idle" ? TEXT.state.idle : TEXT.state.free;
  const item = map.items[held];
  if (view.held[1 - index] === held) return TEXT.state.together(item.shape);
  if (item.size === "small") return TEXT.state.carrying(item.shape);
  if (item.size === "middle") return TEXT.state.slow(item.shape);
  if (own.includes(index)) return TEXT.state.blocked(item.shape);
  return own.length > 0 ? TEXT.state.help : TEXT.state.helpPartner;
}

/** The one sentence that says what to do on this map. @param {GameMap} map */
export function taskSentence(map) {
  const sizes = new Set(map.items.map((item) => item.size));
  const sentence = sizes.has("large") ? TEXT.task.both : sizes.has("middle") ? TEXT.task.some : TEXT.task.small;
  return map.goals.length > 1 ? TEXT.task.goals(sentence) : sentence;
}

/**
 * The connection as a word and a colour.
 * @param {import("../wire/connection.js").Status} status @param {boolean} stalled @param {number} rttMs -1 unknown
 * @returns {{words: string, state: "ok" | "attention" | "bad" | ""}}
 */
export function connectionWords(status, stalled, rttMs) {
  if (status === "connecting") return { words: TEXT.quality.waiting, state: "" };
  if (status !== "open") return { words: TEXT.quality.lost, state: "bad" };
  if (stalled) return { words: TEXT.quality.stalled, state: "bad" };
  if (rttMs < 0) return { words: TEXT.quality.waiting, state: "" };
  const shown = Math.max(1, Math.round(rttMs));
  if (rttMs < 80) return { words: TEXT.quality.good(shown), state: "ok" };
  if (rttMs < 200) return { words: TEXT.quality.fair(shown), state: "attention" };
  return { words: TEXT.quality.poor(shown), state: "bad" };
}
