// Which key or button does what: the table of defaults, the reader's own choice (kept in localStorage) and the names of
// keys for people. What an action is called is in the catalogue: play.settings.action.<action>.

import { has, say } from "../text/catalogue.js";
import { printedOn } from "./keyboard_layout.js";

/** Per action its key in the first and in the second set. A KeyboardEvent.code is the key's place, not its letter. */
const KEYS = /** @type {const} */ ({
  up: ["KeyW", "ArrowUp"],
  left: ["KeyA", "ArrowLeft"],
  down: ["KeyS", "ArrowDown"],
  right: ["KeyD", "ArrowRight"],
  grab: ["Space", "Enter"],
  backward: ["ShiftLeft", "ShiftRight"],
  ping: ["KeyE", "Slash"],
});
/** Per action its index in Gamepad.buttons, in the standard layout. */
const BUTTONS = { grab: 0, backward: 6, ping: 3, pause: 9 };

/** @typedef {keyof typeof KEYS} KeyAction */
/** @typedef {keyof typeof BUTTONS} ButtonAction */
/** @typedef {Record<KeyAction, string>} KeySet  KeyboardEvent.code per action */
/** @typedef {Record<ButtonAction, number>} ButtonSet  index in Gamepad.buttons */
/** @typedef {{keys: [KeySet, KeySet], buttons: ButtonSet, deadZone: number}} Mapping */

export const KEY_ACTIONS = /** @type {KeyAction[]} */ (Object.keys(KEYS));
export const BUTTON_ACTIONS = /** @type {ButtonAction[]} */ (Object.keys(BUTTONS));
export const DEAD_ZONES = /** @type {const} */ ([0.3, 0.15]); // 0.3 is the official collector's
/** Keys that pause the game, whatever else is chosen. */
export const PAUSE_KEYS = Object.freeze(["Escape", "KeyP"]);
const SHORTCUT_KEY = /^(Control|Alt|Meta|OS)/; // Firefox once said OSLeft, and a key without a place is AltGraph
const STORAGE_KEY = "movingout.mapping";

/** Whether a key is for shortcuts: what is pressed with it is the browser's. @param {string} code */
export function isShortcutKey(code) {
  return SHORTCUT_KEY.test(code);
}

/** @param {0 | 1} set @returns {KeySet} */
function defaultKeys(set) {
  return /** @type {KeySet} */ (Object.fromEntries(KEY_ACTIONS.map((action) => [action, KEYS[action][set]])));
}

/** @type {Readonly<Mapping>} */
export const DEFAULTS = Object.freeze({
  keys: /** @type {[KeySet, KeySet]} */ ([defaultKeys(0), defaultKeys(1)]),
  buttons: BUTTONS,
  deadZone: DEAD_ZONES[0],
});

/** @param {Pick<Storage, "getItem">} storage @returns {Mapping} with defaults for what is not kept */
export function loadMapping(storage) {
  try {
    return completed(JSON.parse(storage.getItem(STORAGE_KEY) ?? "{}") ?? {});
  } catch {
    return structuredClone(DEFAULTS); // no storage, or not ours
  }
}

/** Fills in what a mapping lacks, such as an action newer than it. @param {any} kept @returns {Mapping} */
function completed(kept) {
  const slots = DEFAULTS.keys.flatMap((_, set) => KEY_ACTIONS.map((action) => ({ set, action })));
  const codes = filledIn(
    slots.map(({ set, action }) => DEFAULTS.keys[set][action]),
    slots.map(({ set, action }) => kept.keys?.[set]?.[action]),
    (code) => typeof code === "string" && !PAUSE_KEYS.includes(code) && !isShortcutKey(code),
  );
  const indices = filledIn(
    BUTTON_ACTIONS.map((action) => BUTTONS[action]),
    BUTTON_ACTIONS.map((action) => kept.buttons?.[action]),
    (index) => Number.isInteger(index) && Number(index) >= 0,
  );
  /** @type {Mapping} */
  const mapping = structuredClone(DEFAULTS);
  slots.forEach(({ set, action }, slot) => (mapping.keys[set][action] = codes[slot]));
  BUTTON_ACTIONS.forEach((action, slot) => (mapping.buttons[action] = indices[slot]));
  mapping.deadZone = DEAD_ZONES.find((zone) => zone === kept.deadZone) ?? DEFAULTS.deadZone;
  return mapping;
}

/**
 * What was kept, else the default; where that is in use already, a default that is not.
 * @template T
 * @param {readonly T[]} defaults
 * @param {readonly any[]} kept
 * @param {(value: unknown) => boolean} isUsable
 * @returns {T[]}
 */
function filledIn(defaults, kept, isUsable) {
  const used = new Set(kept.filter(isUsable));
  return defaults.map((standard, slot) => {
    if (isUsable(kept[slot])) return kept[slot];
    const value = [standard, ...defaults].find((one) => !used.has(one)) ?? standard;
    used.add(value);
    return value;
  });
}

/** @param {Pick<Storage, "setItem">} storage @param {Mapping} mapping */
export function saveMapping(storage, mapping) {
  try {
    storage.setItem(STORAGE_KEY, JSON.stringify(mapping));
  } catch {
    // Without storage the choice lasts for this page.
  }
}

/** @param {Pick<Storage, "removeItem">} storage */
export function forgetMapping(storage) {
  storage.removeItem(STORAGE_KEY);
}

/** Of one of the two sets alone. @param {Pick<Storage, "getItem" | "setItem">} storage @param {0 | 1} set */
export function forgetKeySet(storage, set) {
  const kept = JSON.parse(storage.getItem(STORAGE_KEY) ?? "{}");
  if (!kept?.keys?.[set]) return;
  kept.keys[set] = {}; // filled in when it is read
  storage.setItem(STORAGE_KEY, JSON.stringify(kept));
}

/**
 * Puts `code` on an action. A key does one thing only: whoever had it gets the old key of this action.
 * @param {Mapping} mapping @param {number} set @param {KeyAction} action @param {string} code @returns {Mapping}
 */
export function withKey(mapping, set, action, code) {
  const changed = structuredClone(mapping);
  const freed = changed.keys[set][action];
  for (const keys of changed.keys) {
    for (const other of KEY_ACTIONS) if (keys[other] === code) keys[other] = freed;
  }
  changed.keys[set][action] = code;
  return changed;
}

/** @param {Mapping} mapping @param {ButtonAction} action @param {number} button @returns {Mapping} */
export function withButton(mapping, action, button) {
  const changed = structuredClone(mapping);
  const freed = changed.buttons[action];
  for (const other of BUTTON_ACTIONS) if (changed.buttons[other] === button) changed.buttons[other] = freed;
  changed.buttons[action] = button;
  return changed;
}

/**
 * What a key does now in either set, other than the action that asks; null: nothing.
 * @param {Mapping} mapping @param {string} code @param {number} askingSet @param {KeyAction} askingAction
 * @returns {{set: number, action: KeyAction} | null}
 */
export function useOfKey(mapping, code, askingSet, askingAction) {
  for (const [set, keys] of mapping.keys.entries()) {
    const action = KEY_ACTIONS.find((one) => keys[one] === code && (set !== askingSet || one !== askingAction));
    if (action) return { set, action };
  }
  return null;
}

/**
 * What else a button does now; null: nothing.
 * @param {Mapping} mapping @param {number} button @param {ButtonAction} asking
 */
export function useOfButton(mapping, button, asking) {
  return BUTTON_ACTIONS.find((action) => mapping.buttons[action] === button && action !== asking) ?? null;
}

/** What is printed on keys of a US keyboard; the names of others are in the catalogue. */
const KEY_SIGNS = new Map([
  ["ArrowUp", "↑"],
  ["ArrowLeft", "←"],
  ["ArrowDown", "↓"],
  ["ArrowRight", "→"],
  ["Comma", ","],
  ["Period", "."],
  ["Slash", "/"],
  ["Semicolon", ";"],
  ["Quote", "'"],
  ["Minus", "-"],
  ["Equal", "="],
  ["Backquote", "`"],
]);
const BUTTON_SIGNS = ["A", "B", "X", "Y", "LB", "RB", "LT", "RT", "Back", "Start"];
const BUTTON_NAMES = ["leftStick", "rightStick", "padUp", "padDown", "padLeft", "padRight"]; // the buttons after these
const HOME = BUTTON_SIGNS.length + BUTTON_NAMES.length;

/** What is printed on the key. @param {string} code */
export function keyName(code) {
  if (has(`key.${code}`)) return say(`key.${code}`);
  if (code.startsWith("Numpad")) return say("key.numpad", { key: code.slice("Numpad".length) });
  return printedOn(code) || (KEY_SIGNS.get(code) ?? code.replace(/^(Key|Digit)/, ""));
}

/** @param {number} button  in the standard layout */
export function buttonName(button) {
  if (button === HOME) return "Home";
  const name = BUTTON_NAMES[button - BUTTON_SIGNS.length];
  return BUTTON_SIGNS[button] ?? (name ? say(`button.${name}`) : say("button.number", { number: button + 1 }));
}

/** The four keys that move, short: "W A S D". @param {KeySet} keys */
export function moveName(keys) {
  return [keys.up, keys.left, keys.down, keys.right].map(keyName).join(" ");
}
