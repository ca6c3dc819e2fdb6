// @ts-check
/*
 * The first two things on the start page: learn the game, or play at once on an easy map beside a partner who helps.
 */

import { byId } from "../core/dom.js";
import { LIMIT_TICKS } from "../messages.js";
import { say } from "../text/catalogue.js";
import { mapTitle } from "../text/names.js";
import { mapPicture } from "../view/render.js";
import { FIRST_MAP, roomRequest } from "./choice.js";

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {import("./choice.js").Choice} Choice */

/** The map of a first game. @param {readonly GameMap[]} maps */
export function firstMap(maps) {
  return maps.find(({ name }) => name === FIRST_MAP) ?? maps[0];
}

/**
 * A first game: the reader is blue, nothing is shuffled, the limit is the paper's.
 * @param {readonly GameMap[]} maps @param {string} partner value of a seat option
 * @returns {Choice}
 */
export function firstChoice(maps, partner) {
  return { map: firstMap(maps).name, seats: ["here", partner], limitTicks: LIMIT_TICKS, seed: null };
}

/** @param {readonly GameMap[]} maps @param {string} partner */
export function firstRequest(maps, partner) {
  const choice = firstChoice(maps, partner);
  return roomRequest(choice, [choice.map], false, partner);
}

/** Writes what "Play now" leads to. @param {readonly GameMap[]} maps */
export function showFirstGame(maps) {
  byId("now-help", HTMLElement).textContent = say("lobby.now.help", { map: mapTitle(firstMap(maps)) });
}

/** @param {readonly GameMap[]} maps @param {GameMap | null} practiceMap */
export function drawFirstPictures(maps, practiceMap) {
  if (maps.length === 0) return;
  mapPicture(byId("now-picture", HTMLCanvasElement), firstMap(maps));
  if (practiceMap) mapPicture(byId("learn-picture", HTMLCanvasElement), practiceMap);
}
