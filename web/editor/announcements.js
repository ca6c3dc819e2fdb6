// @ts-check
/*
 * What the drawing says to those who do not see it: where a part now is, how it is turned, what was added or undone.
 */

import { byId } from "../core/dom.js";
import { say, sayNumber } from "../text/catalogue.js";
import { sides, thing } from "./parts.js";

/** @typedef {import("./parts.js").GameMap} GameMap */
/** @typedef {import("./parts.js").Part} Part */

/** @param {string} sentence for a screen reader */
export function announce(sentence) {
  byId("announce", HTMLElement).textContent = sentence;
}

/** "x 0.05; y -0.40"; of a wall or green area its left and lower side. @param {GameMap} map @param {Part} part */
export function placeText(map, part) {
  const it = thing(map, part);
  if (!("x0" in it)) return listed({ x: it.x, y: it.y });
  const { left, bottom } = sides(it);
  return listed({ left, bottom });
}

/** "Angle in degrees 15"; of a wall or green area its sides. @param {GameMap} map @param {Part} part */
export function turnText(map, part) {
  const it = thing(map, part);
  if (!("x0" in it)) return `${say("editor.field.angle")} ${sayNumber((it.angle * 180) / Math.PI, 0)}`;
  const { left, bottom, right, top } = sides(it);
  return listed({ width: right - left, height: top - bottom });
}

/** @param {Record<string, number>} values by the names of their fields */
function listed(values) {
  return Object.entries(values)
    .map(([field, value]) => `${say(`editor.field.${field}`)} ${sayNumber(Math.round(value * 100) / 100 + 0, 2)}`)
    .join("; ");
}
