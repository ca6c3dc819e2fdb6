// @ts-check
/*
 * The map that the address asks for, /?map=HandOff:mirror, where it stands in no list: it was just played in this tab,
 * though another drawing of its name may be listed, or the server knows it by its name. And the number of shuffled
 * items, &seed=7.
 */

import { requestJson } from "../core/api.js";
import { isOffered, keptPlayed } from "../wire/played_map.js";
import { parseSeed } from "./choice.js";

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {{map: GameMap, key: "lobby.played" | "lobby.linked"}} ExtraMap key: of its heading */

const LISTED = "listed"; // in the address, on the way to another language

/** The name of the map that the address asks for. */
export function wantedName() {
  return new URLSearchParams(location.search).get("map") ?? "";
}

/**
 * What its card is called among the others: one of the operator's maps may have the name of the one just played.
 * @param {ExtraMap} extra
 */
export function cardOf({ map, key }) {
  return key === "lobby.played" ? `played:${map.name}` : map.name;
}

/**
 * Whether the address asks for the listed map of its name, though another drawing of that name was just played: it was
 * chosen, and then another language. It stands there no longer, because in a copied address it would mean nothing.
 */
export function takeListed() {
  const query = new URLSearchParams(location.search);
  if (!query.has(LISTED)) return false;
  query.delete(LISTED);
  const asked = String(query);
  history.replaceState(history.state, "", `${location.pathname}${asked && `?${asked}`}${location.hash}`);
  return true;
}

/**
 * The number for shuffled items that the address asks for; null where it asks for none, or for a drawn map whose items
 * are shuffled already.
 * @param {ExtraMap | null} extra
 */
export function wantedSeed(extra) {
  const seed = parseSeed(new URLSearchParams(location.search).get("seed") ?? "");
  return extra?.map.variant ? null : seed;
}

/**
 * The address's query for another language: it goes on asking for the map and the number chosen, and leaves out ?lang=.
 * @param {Pick<import("./choice.js").Choice, "map" | "seed"> | null} chosen its map by name; null: nothing yet
 * @param {boolean} listed whether that is the listed map of two of its name
 */
export function queryFor(chosen, listed) {
  const query = new URLSearchParams(location.search);
  query.delete("lang");
  if (chosen && query.has("map")) query.set("map", chosen.map);
  if (listed) query.set(LISTED, "yes");
  if (chosen) query.delete("seed");
  if (chosen && chosen.seed !== null) query.set("seed", String(chosen.seed));
  const asked = String(query);
  return asked && `?${asked}`;
}

/**
 * @param {import("../wire/played_map.js").Offered} offered
 * @returns {Promise<ExtraMap | null>} null where it asks for none of these; ApiError where there is no such map
 */
export async function extraMap(offered) {
  const name = wantedName();
  if (name === "") return null;
  const played = keptPlayed(name);
  const isListed = [...offered.shipped, ...offered.own].some((map) => map.name === name);
  if (played ? isOffered(played, offered) : isListed) return null;
  const isNamed = Boolean(played?.variant) && name.includes(":"); // the server has it as designed
  if (played && !isNamed) return { map: played, key: "lobby.played" };
  return { map: await requestJson(`/api/maps/${encodeURIComponent(name)}`), key: "lobby.linked" };
}
