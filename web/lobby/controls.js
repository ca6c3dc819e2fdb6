// @ts-check
/*
 * The controls card of the lobby: what to press per device, with the reader's own keys where they were changed.
 * The game page shows the keys of the device in use itself.
 */

import { lastingStorage } from "../core/browser_storage.js";
import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";
import { buttonName, keyName, loadMapping, moveName } from "../input/mapping.js";

/** @typedef {readonly [string, string]} Row what to press, what it does */

/** @param {Pick<Storage, "getItem">} [storage] @returns {HTMLElement} */
export function controlsCard(storage = lastingStorage()) {
  const { keys, buttons } = loadMapping(storage);
  const [first, second] = keys;
  return el(
    "div",
    { class: "controls" },
    table(say("lobby.controls.keyboard"), [
      [`${moveName(first)} · ${moveName(second)}`, say("lobby.controls.move")],
      [`${keyName(first.grab)} · ${keyName(second.grab)}`, say("lobby.controls.grab")],
      [`${keyName(first.backward)} · ${keyName(second.backward)}`, say("lobby.controls.backward")],
    ]),
    table(say("lobby.controls.gamepad"), [
      [say("button.leftStick"), say("lobby.controls.move")],
      [buttonName(buttons.grab), say("lobby.controls.grab")],
      [buttonName(buttons.backward), say("lobby.controls.backward")],
    ]),
    table(say("lobby.controls.touch"), [
      [say("lobby.controls.stick"), say("lobby.controls.drag")],
      [say("lobby.controls.button"), say("lobby.controls.grab")],
    ]),
    el("p", { class: "field-help" }, say("lobby.controls.two")),
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
  const names = keys.split(" · ").map((name) => el("kbd", { translate: "no" }, name));
  return el("tr", {}, el("th", { scope: "row" }, ...names), el("td", {}, effect));
}
