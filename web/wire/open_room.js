// @ts-check
/*
 * Opens a room on the server and keeps its seats in this tab, so that the game page finds them.
 */

import { requestJson } from "../core/api.js";
import { requireStorage } from "../core/browser_storage.js";
import { saveTokens } from "./seat_tokens.js";

/** @typedef {{room: string, tokens: (string | null)[], join_path: string, watch_path: string}} OpenedRoom */

/**
 * @param {unknown} body of POST /api/rooms
 * @returns {Promise<OpenedRoom>} ApiError when the server refuses
 */
export async function openRoom(body) {
  requireStorage();
  const room = await requestJson("/api/rooms", { body });
  saveTokens(room.room, room.tokens);
  return room;
}
