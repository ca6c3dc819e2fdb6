// @ts-check
/*
 * The round mark of a seat where no word beside it says the colour.
 */

import { badge } from "../core/dom.js";
import { colourName } from "../text/names.js";

/** A badge that a screen reader calls by its colour. @param {number} seat 0 blue, 1 red */
export function namedBadge(seat) {
  const mark = badge(seat);
  mark.removeAttribute("aria-hidden");
  mark.setAttribute("role", "img");
  mark.setAttribute("aria-label", colourName(seat));
  return mark;
}
