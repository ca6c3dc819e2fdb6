// @ts-check
/*
 * What keeps a map from being played, in the reader's language, and which part of the drawing it is about.
 */

import { has, say } from "../text/catalogue.js";
import { colourName, colourWord } from "../text/names.js";
import { COLOURS, partAt } from "./parts.js";

/** @typedef {import("./parts.js").GameMap} GameMap */
/** @typedef {import("./parts.js").Part} Part */
/**
 * @typedef {object} Fault as the server found it
 * @property {string} path
 * @property {string} message the checker's own sentence, in English
 * @property {string} code
 * @property {Record<string, unknown>} values
 */

/** What is missing before the server need be asked. @param {GameMap} map @returns {Fault[]} */
export function missing(map) {
  /** @type {Fault[]} */
  const found = [];
  if (map.goals.length === 0) found.push({ path: "goals", message: "", code: "no_goals", values: {} });
  if (map.items.length === 0) found.push({ path: "items", message: "", code: "no_items", values: {} });
  return found;
}

/** "Item 2", "Wall 1", "Red robot": the parts are counted from 1. @param {Part} part */
export function partName({ kind, index }) {
  if (kind === "robots") return say("editor.part.robot", { colour: colourName(index) });
  return say(`editor.part.${kind}`, { number: index + 1 });
}

/** @param {unknown} path */
function placeName(path) {
  const part = partAt(String(path));
  return part ? partName(part) : placeInFile(String(path));
}

/** Where something stands in the file of a map: "items[1].shape". @param {string} path */
function placeInFile(path) {
  return path === "the map" ? say("editor.open.wholeMap") : path;
}

/** A fault as a sentence; what no page has words for stays the checker's own. @param {Fault} fault */
export function faultText({ path, message, code, values }) {
  const key = `fault.${code}`;
  if (!has(key)) return `${placeName(path)}: ${message}`;
  const { other, items, colours, ...numbers } = values;
  return say(key, {
    ...numbers,
    place: placeName(path),
    path: placeInFile(path),
    other: placeName(other),
    items: Array.isArray(items) ? items.map(placeName) : [],
    colours: Array.isArray(colours) ? colours.map((colour) => colourWord(COLOURS.indexOf(colour))) : [],
  });
}

/** The parts that faults are about. @param {readonly Fault[]} faults @returns {Part[]} */
export function faultyParts(faults) {
  return faults.flatMap(({ path, values }) => {
    const paths = [path, String(values.other ?? ""), ...(Array.isArray(values.items) ? values.items : [])];
    return paths.map(partAt).filter((part) => part !== null);
  });
}
