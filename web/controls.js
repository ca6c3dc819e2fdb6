// @ts-check
/*
 * The controls card: what to press, per device, as the game has it out of the box. Used by the lobby; the game page
 * shows the keys of the device in use itself.
 */

import { el } from "./dom.js";

/** @type {readonly {device: string, rows: readonly (readonly [readonly string[], string])[]}[]} */
const DEVICES = [
  {
    device: "Keyboard",
    rows: [
      [["W", "A", "S", "D"], "move (or the arrow keys)"],
      [["Space", "Enter"], "grab, let go"],
      [["Shift"], "hold to drive backward"],
    ],
  },
  {
    device: "Gamepad",
    rows: [
      [["left stick"], "move"],
      [["A"], "grab, let go"],
      [["LT"], "hold to drive backward"],
    ],
  },
  {
    device: "Touch",
    rows: [
      [["left half"], "drag to move"],
      [["button"], "grab, let go"],
    ],
  },
];

/** @returns {HTMLElement} */
export function controlsCard() {
  return el(
    "div",
    { class: "controls" },
    ...DEVICES.map(({ device, rows }) =>
      el("table", {}, el("caption", {}, device), el("tbody", {}, ...rows.map(([keys, effect]) => controlRow(keys, effect)))),
    ),
  );
}

/** @param {readonly string[]} keys @param {string} effect */
function controlRow(keys, effect) {
  return el("tr", {}, el("th", { scope: "row" }, ...keys.map((key) => el("kbd", {}, key))), el("td", {}, effect));
}
