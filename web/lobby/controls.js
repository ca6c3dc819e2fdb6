// @ts-check
/*
 * The controls card of the lobby: what to press per device, with the reader's own keys where they were changed.
 * The game page shows the keys of the device in use itself.
 */

import { el } from "../core/dom.js";
import { buttonName, keyName, loadMapping, moveName } from "../input/mapping.js";

/** @typedef {readonly [string, string]} Row what to press, what it does */

/** @param {Pick<Storage, "getItem">} [storage] @returns {HTMLElement} */
export function controlsCard(storage = localStorage) {
  const { keys, buttons } = loadMapping(storage);
  const [first, second] = keys;
  return el(
    "div",
    { class: "controls" },
    table("Keyboard", [
      [`${moveName(first)} · ${moveName(second)}`, "move"],
      [`${keyName(first.grab)} · ${keyName(second.grab)}`, "grab, let go"],
      [`${keyName(first.backward)} · ${keyName(second.backward)}`, "hold to drive backward"],
    ]),
    table("Gamepad", [
      ["left stick", "move"],
      [buttonName(buttons.grab), "grab, let go"],
      [buttonName(buttons.backward), "hold to drive backward"],
    ]),
    table("Touch", [
      ["stick", "drag to move"],
      ["button", "grab, let go"],
    ]),
    el("p", { class: "field-help" }, "Two at one keyboard: blue has the first keys, red the second."),
  );
}

/** @param {string} device @param {readonly Row[]} rows */
function table(device, rows) {
  return el(
    "table",
    {},
    el("caption", {}, device),
    el("tbody", {}, ...rows.map(([keys, effect]) => row(keys, effect))),
  );
}

/** @param {string} keys one name, or two with a dot between @param {string} effect */
function row(keys, effect) {
  const names = keys.split(" · ").map((name) => el("kbd", {}, name));
  return el("tr", {}, el("th", { scope: "row" }, ...names), el("td", {}, effect));
}
