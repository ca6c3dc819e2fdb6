// @ts-check
/*
 * The maps to choose from: by mode, each with its picture, its title and how hard it is.
 */

import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";
import { mapDescription, mapTitle } from "../text/names.js";
import { MODES, modeKey } from "./choice.js";
import { difficulty } from "./difficulty.js";
import { cardOf } from "./extra_map.js";

/** @typedef {import("../view/render.js").GameMap} GameMap */

/** @typedef {{maps: readonly GameMap[], leftOut: number}} OwnMaps of the folder that the server was started with */

/**
 * The map that the address asks for, where no list has it, the operator's own maps, where there are any, then the
 * others by mode; the card `selected` is chosen.
 * @param {readonly GameMap[]} maps @param {OwnMaps} own @param {import("./extra_map.js").ExtraMap | null} extra
 * @param {string} selected
 */
export function mapGroups(maps, own, extra, selected) {
  const modes = MODES.map((mode) =>
    mapGroup(
      modeKey(mode),
      maps.filter((map) => map.mode === mode),
      selected,
    ),
  );
  const first = extra ? [mapGroup(extra.key, [extra.map], selected, cardOf(extra))] : [];
  if (own.maps.length + own.leftOut === 0) return [...first, ...modes];
  const yours = mapGroup("lobby.own", own.maps, selected);
  if (own.leftOut > 0)
    yours.append(el("p", { class: "map-note muted small" }, say("lobby.own.leftOut", { count: own.leftOut })));
  return [...first, yours, ...modes];
}

/**
 * @param {string} key of its heading @param {readonly GameMap[]} maps @param {string} selected
 * @param {string} [only] the card of its only map
 */
function mapGroup(key, maps, selected, only) {
  const cards = maps.map((map) => mapCard(map, only ?? map.name, selected));
  return el(
    "fieldset",
    { class: "map-group" },
    el("legend", {}, el("h2", {}, say(key)), el("span", { class: "muted small" }, say(`${key}.help`))),
    ...cards,
  );
}

/** @param {GameMap} map @param {string} card @param {string} selected */
function mapCard(map, card, selected) {
  return el(
    "label",
    { class: "map" },
    el("input", {
      type: "radio",
      name: "map",
      value: card,
      checked: card === selected,
      "aria-describedby": `about-${card}`,
    }),
    el("canvas", { "aria-hidden": "true", "data-map": card }),
    el("span", { class: "map-title" }, mapTitle(map)),
    dots(difficulty(map)),
    el("span", { class: "sr-only", id: `about-${card}` }, mapDescription(map)),
  );
}

/** How hard a map is, as a word and as dots. @param {number} level 1 to 3 */
function dots(level) {
  const marks = [1, 2, 3].map((place) => el("span", { class: place <= level ? "dot dot-full" : "dot" }));
  return el(
    "span",
    { class: "map-difficulty" },
    el("span", { class: "dots", "aria-hidden": "true" }, ...marks),
    say(`lobby.difficulty.${level}`),
  );
}
