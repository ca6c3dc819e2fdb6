// @ts-check
/*
 * Filters of the list of recordings. Pure.
 */

import { playerName } from "../text/names.js";

/**
 * @typedef {object} Row one line of GET /api/recordings; an unreadable file has `damage` and little else
 * @property {string} id
 * @property {string} started UTC, ISO 8601
 * @property {string} [map] its name
 * @property {string} [title] of a map of somebody's own
 * @property {number} [ticks]
 * @property {string} [outcome]
 * @property {string} [blue] kind and name
 * @property {string} [red]
 * @property {Partial<Record<import("../messages.js").MetricKey, number>>} [metrics] as the wire has them
 * @property {boolean} complete
 * @property {string} [damage]
 */
/** @typedef {{map: string, player: string, outcome: string}} Filter empty: any; `map` as of `mapOf` */

/** The map of a recording for the filter: drawn maps may have one name and different titles. @param {Row} row */
export function mapOf({ map, title = "" }) {
  return map && (title ? `${map} ${title}` : map);
}

/** @param {readonly Row[]} rows @param {Filter} filter */
export function filterRecordings(rows, { map, player, outcome }) {
  return rows.filter(
    (row) =>
      (!map || mapOf(row) === map) &&
      (!player || row.blue === player || row.red === player) &&
      (!outcome || row.outcome === outcome),
  );
}

/** What can be chosen for each filter, sorted. @param {readonly Row[]} rows */
export function filterChoices(rows) {
  return {
    map: distinct(rows.map(mapOf)),
    player: distinct(rows.flatMap((row) => [row.blue, row.red])),
    outcome: distinct(rows.map((row) => row.outcome)),
  };
}

/** @param {(string | undefined)[]} values @returns {string[]} */
function distinct(values) {
  return [...new Set(values.filter((value) => value !== undefined && value !== ""))].sort().map(String);
}

/** "human P1" or "agent bass@all" as people read it. @param {string} [player] */
export function playerWords(player = "") {
  const [kind, ...name] = player.split(" ");
  return playerName(kind, name.join(" ").trim());
}
