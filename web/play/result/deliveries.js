// @ts-check
/*
 * Who delivered what in a round: every item as it looks, with the name of who brought it home.
 */

import { namedBadge } from "../../components/named_badge.js";
import { el } from "../../core/dom.js";
import { outline, radiusOf } from "../../shapes.js";
import { say } from "../../text/catalogue.js";
import { shapeName } from "../../text/names.js";

/** @typedef {import("../../view/render.js").Item} Item */

const SVG = "http://www.w3.org/2000/svg";
const MARGIN = 1.5; // of the largest item, for the corners of a star

/**
 * @param {readonly Item[]} items
 * @param {readonly (readonly number[])[]} deliveredBy per item the seats that brought it home
 * @param {readonly boolean[]} delivered per item
 * @param {readonly string[]} names of the seats
 */
export function deliveryList(items, deliveredBy, delivered, names) {
  const reach = MARGIN * Math.max(...items.map(({ scale }) => scale));
  const entries = items.map((item, index) =>
    el(
      "li",
      { class: delivered[index] ? "delivery delivery-done" : "delivery" },
      picture(item, reach),
      el("span", { class: "sr-only" }, `${shapeName(item.shape)}: `),
      el("span", { class: "delivery-who" }, ...who(deliveredBy[index] ?? [], delivered[index], names)),
    ),
  );
  return el("ul", { class: "deliveries" }, ...entries);
}

/** @param {readonly number[]} seats @param {boolean} delivered @param {readonly string[]} names */
function who(seats, delivered, names) {
  if (!delivered) return [say("play.result.nobody")];
  if (seats.length === 0) return [say("play.result.itself")];
  return [...seats.map(namedBadge), seats.length > 1 ? say("play.result.together") : names[seats[0]]];
}

/** @param {Item} item @param {number} reach half the side of the picture, in arena units */
function picture(item, reach) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", `${-reach} ${-reach} ${2 * reach} ${2 * reach}`);
  svg.setAttribute("class", `delivery-item delivery-${item.size}`);
  svg.setAttribute("aria-hidden", "true");
  svg.append(item.shape === "circle" ? circle(item) : polygon(item));
  return svg;
}

/** @param {Item} item */
function circle({ shape, scale }) {
  const node = document.createElementNS(SVG, "circle");
  node.setAttribute("r", String(radiusOf(shape, scale)));
  return node;
}

/** @param {Item} item */
function polygon({ shape, scale }) {
  const node = document.createElementNS(SVG, "polygon");
  node.setAttribute(
    "points",
    outline(shape, scale)
      .map(([x, y]) => `${x},${-y}`)
      .join(" "),
  );
  return node;
}
