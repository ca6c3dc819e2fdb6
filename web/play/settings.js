// The dialog for keys and buttons: choose an action, press the new key. Every change is saved at once.

import { lastingStorage } from "../core/browser_storage.js";
import { byId, el, notice } from "../core/dom.js";
import { codeOf } from "../input/keyboard_layout.js";
import {
  BUTTON_ACTIONS,
  buttonName,
  DEAD_ZONES,
  DEFAULTS,
  isShortcutKey,
  KEY_ACTIONS,
  keyName,
  PAUSE_KEYS,
  saveMapping,
  useOfButton,
  useOfKey,
  withButton,
  withKey,
} from "../input/mapping.js";
import { say, sayNumber } from "../text/catalogue.js";

/** @typedef {import("../input/mapping.js").Mapping} Mapping */
/** @typedef {import("../input/gamepad.js").Gamepads} Gamepads */

const POLL_MS = 30;

export class Settings {
  #dialog = byId("settings", HTMLDialogElement);
  offersPings = false; // whether the key for pings can be used in this room
  #lastId = ""; // of what was last changed here: the keyboard stays there when everything is drawn anew
  /** @type {() => void} stops waiting for a key or button */
  #cancel = () => {};

  /** @param {Mapping} mapping @param {Gamepads} gamepads @param {() => void} onClose */
  constructor(mapping, gamepads, onClose) {
    this.mapping = mapping;
    this.gamepads = gamepads;
    this.#dialog.addEventListener("keydown", (event) => {
      if (event.repeat && event.key === "Enter") event.preventDefault(); // one press is one press of a button
    });
    this.#dialog.addEventListener("close", () => {
      this.#cancel();
      onClose();
    });
  }

  get isOpen() {
    return this.#dialog.open;
  }

  open() {
    this.#lastId = "";
    this.#draw();
    if (!this.#dialog.open) this.#dialog.showModal();
  }

  /** @param {Mapping} mapping */
  #change(mapping) {
    this.mapping = mapping;
    saveMapping(lastingStorage(), mapping);
    this.#draw();
  }

  /** @param {HTMLElement} [question] about the key that was pressed just now */
  #draw(question) {
    this.#cancel();
    const sets = this.mapping.keys.map((_, set) => this.#keySet(set));
    this.#dialog.replaceChildren(
      el(
        "div",
        { class: "stack" },
        el("h2", { id: "settings-title" }, say("play.settings.title")),
        el("p", { class: "muted" }, say("play.settings.intro")),
        question,
        el("div", { class: "binding-sets" }, ...sets, this.#pad()),
        el(
          "div",
          { class: "row row-apart" },
          el(
            "button",
            { type: "button", class: "button", id: "settings-reset", onclick: () => this.#reset() },
            say("play.settings.reset"),
          ),
          el(
            "button",
            { type: "button", class: "button button-primary", onclick: () => this.#dialog.close() },
            say("play.settings.done"),
          ),
        ),
      ),
    );
    document.getElementById(this.#lastId)?.focus();
  }

  #reset() {
    this.#lastId = "settings-reset";
    this.#change(structuredClone(DEFAULTS));
  }

  /** @param {number} set */
  #keySet(set) {
    const rows = this.#offered(KEY_ACTIONS).map((action) => {
      const name = keyName(this.mapping.keys[set][action]);
      return binding(`key-${set}-${action}`, say(`play.settings.action.${action}`), name, (button) =>
        this.#askKey(button, set, action),
      );
    });
    return el("div", { class: "bindings" }, el("h3", {}, say(`play.settings.keySet.${set + 1}`)), ...rows);
  }

  /** @template {string} Action @param {readonly Action[]} actions */
  #offered(actions) {
    return actions.filter((action) => action !== "ping" || this.offersPings);
  }

  #pad() {
    const rows = this.#offered(BUTTON_ACTIONS).map((action) => {
      const name = buttonName(this.mapping.buttons[action]);
      return binding(`pad-${action}`, say(`play.settings.action.${action}`), name, (button) =>
        this.#askButton(button, action),
      );
    });
    const zone = el(
      "select",
      { class: "select", id: "dead-zone" },
      ...DEAD_ZONES.map((value, index) =>
        el(
          "option",
          { value },
          index === 0 ? say("play.settings.usual", { value: sayNumber(value, 1) }) : sayNumber(value, 2),
        ),
      ),
    );
    zone.value = String(this.mapping.deadZone);
    zone.addEventListener("change", () => {
      this.#lastId = zone.id;
      this.#change({ ...this.mapping, deadZone: Number(zone.value) });
    });
    const field = el(
      "div",
      { class: "field small" },
      el("label", { for: "dead-zone" }, say("play.settings.deadZone")),
      zone,
    );
    return el("div", { class: "bindings" }, el("h3", {}, say("play.settings.gamepad")), ...rows, field);
  }

  /** @param {HTMLElement} asked @param {string} request to press something */
  #ask({ id }, request) {
    this.#lastId = id;
    this.#draw(); // a button that asked before has its name again
    const button = byId(id, HTMLElement);
    button.textContent = request;
    button.setAttribute("aria-label", request);
  }

  /** @param {HTMLElement} button @param {number} set @param {import("../input/mapping.js").KeyAction} action */
  #askKey(button, set, action) {
    this.#ask(button, say("play.settings.press"));
    const listen = (/** @type {KeyboardEvent} */ event) => {
      event.preventDefault();
      event.stopImmediatePropagation();
      if (event.repeat) return; // the key that asked is still down
      this.#cancel();
      this.#chooseKey(set, action, codeOf(event));
    };
    addEventListener("keydown", listen, { capture: true });
    this.#cancel = () => {
      removeEventListener("keydown", listen, { capture: true });
      this.#cancel = () => {};
    };
  }

  /** @param {number} set @param {import("../input/mapping.js").KeyAction} action @param {string} code */
  #chooseKey(set, action, code) {
    const name = keyName(code);
    if (code === "Escape") return this.#draw();
    if (PAUSE_KEYS.includes(code)) return this.#draw(notice("bad", say("play.settings.pauses", { name })));
    if (isShortcutKey(code)) return this.#draw(notice("bad", say("play.settings.shortcuts", { name })));
    const use = useOfKey(this.mapping, code, set, action);
    const changed = withKey(this.mapping, set, action, code);
    if (use === null) return this.#change(changed);
    const other = `${say(`play.settings.action.${use.action}`)} (${say(`play.settings.keySet.${use.set + 1}`)})`;
    this.#askSwap(name, other, changed);
  }

  /** @param {import("../input/mapping.js").ButtonAction} action @param {number} button */
  #chooseButton(action, button) {
    const use = useOfButton(this.mapping, button, action);
    const changed = withButton(this.mapping, action, button);
    if (use === null) this.#change(changed);
    else this.#askSwap(buttonName(button), say(`play.settings.action.${use}`), changed);
  }

  /**
   * A key does one thing: asks before two actions exchange theirs.
   * @param {string} name of the key @param {string} other what it does now @param {Mapping} changed
   */
  #askSwap(name, other, changed) {
    const swap = el("button", { type: "button", class: "button button-small" }, say("play.settings.swap"));
    const keep = el("button", { type: "button", class: "button button-small" }, say("play.settings.keep"));
    swap.addEventListener("click", () => this.#change(changed));
    keep.addEventListener("click", () => this.#draw());
    const sentence = el("p", {}, say("play.settings.used", { name, other }));
    const box = el(
      "div",
      { class: "notice notice-attention stack stack-tight", role: "alert" },
      sentence,
      el("div", { class: "row" }, swap, keep),
    );
    this.#draw(box);
    keep.focus();
  }

  /** @param {HTMLElement} button @param {import("../input/mapping.js").ButtonAction} action */
  #askButton(button, action) {
    this.#ask(button, say("play.settings.pressButton"));
    this.gamepads.read(this.mapping); // buttons already down do not count
    const timer = setInterval(() => {
      const pressed = this.gamepads.pressedButton(this.mapping);
      if (pressed !== null) this.#chooseButton(action, pressed);
    }, POLL_MS);
    this.#cancel = () => {
      clearInterval(timer);
      this.#cancel = () => {};
    };
  }
}

/** @param {string} id @param {string} action @param {string} name @param {(button: HTMLElement) => void} ask */
function binding(id, action, name, ask) {
  const button = el(
    "button",
    { type: "button", id, class: "button button-small", "aria-label": `${action}: ${name}` },
    name,
  );
  button.addEventListener("click", () => ask(button));
  return el("div", { class: "binding" }, el("span", {}, action), button);
}
