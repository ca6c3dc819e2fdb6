// @ts-check
/*
 * What things are called that several pages show: colours, shapes, maps, agents, keys. What the catalogue does not
 * know, such as a map or an agent of one's own, keeps the name that the server gives it.
 */

import { currentLanguage, has, say } from "./catalogue.js";

const COLOURS = ["blue", "red"];

/** "Blue", for seat 0. @param {number} seat */
export function colourName(seat) {
  return say(`colour.${COLOURS[seat]}`);
}

/** "blue", within a sentence. @param {number} seat */
export function colourWord(seat) {
  return colourName(seat).toLocaleLowerCase(currentLanguage());
}

/** "a square", as the object of a sentence. @param {string} shape */
export function shapeObject(shape) {
  return has(`shape.${shape}`) ? say(`shape.${shape}`) : say("shape.unknown");
}

/**
 * The title of a map; of an unknown one without a title its name, in words: "HandOff" -> "Hand Off".
 * @param {{name: string, title?: string}} map
 */
export function mapTitle({ name, title = name.replace(/([a-z])([A-Z])/g, "$1 $2") }) {
  return has(`map.${name}.title`) ? say(`map.${name}.title`) : title;
}

/** @param {{name: string, description: string}} map */
export function mapDescription({ name, description }) {
  return has(`map.${name}.description`) ? say(`map.${name}.description`) : description;
}

/** The name of an agent by its id, "bass@all" or "scripted:seed=3". @param {string} id @param {string} [otherwise] */
export function agentName(id, otherwise = id) {
  const key = `agent.${id.split(/[@:]/)[0]}`;
  return has(key) ? say(key) : otherwise;
}
