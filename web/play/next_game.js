// @ts-check
/*
 * The game after a finished one with the same partner: the next map, or the same one where its room cannot go on. Only
 * where nobody else has to come along.
 */

import { requestJson } from "../core/api.js";
import { openRoom } from "../wire/open_room.js";
import { isDrawnIn, keepDrawnIn, wantedMap } from "../wire/played_map.js";

/** @typedef {import("./game.js").Game} Game */
/** @typedef {import("../messages.js").SeatState} SeatState */

/** @typedef {{kind: "here" | "agent", agent?: string}} SeatRequest */

/**
 * The seats of a further game; null where another person, a program or a recording sits opposite.
 * @param {readonly SeatState[]} seats @param {readonly number[]} own
 * @returns {SeatRequest[] | null}
 */
export function sameSeats(seats, own) {
  if (own.length === 0) return null;
  const wanted = seats.map((seat, index) => (own.includes(index) ? ownSeat() : programSeat(seat)));
  const possible = wanted.filter((seat) => seat !== null);
  return possible.length === wanted.length ? possible : null;
}

/** @returns {SeatRequest} */
function ownSeat() {
  return { kind: "here" };
}

/** @param {SeatState} seat @returns {SeatRequest | null} */
function programSeat({ kind, name }) {
  if (kind === "idle") return { kind: "agent", agent: "idle" };
  return kind === "agent" ? { kind: "agent", agent: name } : null;
}

/** The map after `name`, the first after the last. @param {readonly string[]} names @param {string} name */
export function nextMap(names, name) {
  return names[(names.indexOf(name) + 1) % names.length];
}

/**
 * Opens a room with the same seats and time limit and goes there.
 * @param {Game} game @param {"next" | "same"} which map
 * @returns {Promise<void>} ApiError when the server refuses
 */
export async function goOn(game, which) {
  const seats = sameSeats(game.room?.seats ?? [], game.own);
  if (seats === null || game.round === null) return;
  const { map, limit_ticks } = game.round;
  const { maps, own = [], practice } = await requestJson("/api/maps");
  const name = which === "same" ? map.name : nextMap(maps.map(nameOf), map.name);
  const offered = { shipped: [...maps, practice], own };
  const room = await openRoom({ ...wantedMap(map, name, offered), seats, limit_ticks });
  if (which === "same" && isDrawnIn(game.welcome?.room ?? "")) keepDrawnIn(room.room);
  location.assign(room.join_path);
}

/** @param {{name: string}} map */
function nameOf({ name }) {
  return name;
}
