import assert from "node:assert/strict";
import { test } from "node:test";

import { has } from "../../text/catalogue.js";
import {
  BUTTON_ACTIONS,
  buttonName,
  DEFAULTS,
  isShortcutKey,
  KEY_ACTIONS,
  keyName,
  loadMapping,
  moveName,
  saveMapping,
  useOfButton,
  useOfKey,
  withButton,
  withKey,
} from "../../input/mapping.js";
import { speak } from "../text/support.js";

speak("en");

/** @param {string | null} value */
const storage = (value) => ({ getItem: () => value });

test("a mapping comes back as it was kept", () => {
  let kept = "";
  const mapping = withKey(structuredClone(DEFAULTS), 0, "grab", "KeyE");
  saveMapping({ setItem: (_, value) => (kept = value) }, mapping);
  assert.deepEqual(loadMapping(storage(kept)), mapping);
});

test("a kept key that pauses the game gives way to the default", () => {
  const kept = structuredClone(DEFAULTS);
  kept.keys[0].grab = "KeyP";
  kept.keys[1].up = "Escape";
  assert.deepEqual(loadMapping(storage(JSON.stringify(kept))), DEFAULTS);
});

test("a kept key for shortcuts gives way to the default: it never did anything", () => {
  for (const code of ["ControlLeft", "ControlRight", "AltLeft", "AltRight", "AltGraph", "MetaLeft", "OSRight"]) {
    const kept = structuredClone(DEFAULTS);
    kept.keys[0].backward = code;
    assert.deepEqual(loadMapping(storage(JSON.stringify(kept))), DEFAULTS, code);
    assert.ok(isShortcutKey(code), code);
  }
  assert.ok(DEFAULTS.keys.flatMap((keys) => Object.values(keys)).every((code) => !isShortcutKey(code)));
});

test("nothing usable in storage means the defaults", () => {
  for (const value of [null, "", "{", "[]", "{}", '{"keys":[{},{}],"buttons":{},"deadZone":0.3}', '"x"']) {
    assert.deepEqual(loadMapping(storage(value)), DEFAULTS, String(value));
  }
  const forbidden = {
    getItem: () => {
      throw new Error("forbidden");
    },
  };
  assert.deepEqual(loadMapping(forbidden), DEFAULTS);
});

test("an action that the kept mapping lacks gets its default, and the kept choices stay", () => {
  const mapping = withButton(withKey(structuredClone(DEFAULTS), 0, "grab", "KeyE"), "grab", 3);
  const kept = JSON.parse(JSON.stringify({ ...mapping, deadZone: 0.15 }));
  delete kept.keys[0].backward;
  delete kept.keys[1].backward;
  delete kept.buttons.pause;
  assert.deepEqual(loadMapping(storage(JSON.stringify(kept))), { ...mapping, deadZone: 0.15 });
});

test("a default that a kept choice uses gives way to a free key", () => {
  const kept = structuredClone(DEFAULTS);
  kept.keys[0].grab = "ShiftLeft";
  const { backward, ...others } = kept.keys[0];
  const loaded = loadMapping(storage(JSON.stringify({ ...kept, keys: [others, kept.keys[1]] })));
  assert.deepEqual([backward, loaded.keys[0].grab, loaded.keys[0].backward], ["ShiftLeft", "ShiftLeft", "Space"]);
});

test("a key does one thing only: its old action gets the key that became free", () => {
  const changed = withKey(structuredClone(DEFAULTS), 0, "grab", "Enter");
  assert.equal(changed.keys[0].grab, "Enter");
  assert.equal(changed.keys[1].grab, "Space");
  assert.equal(DEFAULTS.keys[0].grab, "Space");
});

test("a button does one thing only", () => {
  const changed = withButton(structuredClone(DEFAULTS), "grab", 6);
  assert.deepEqual(changed.buttons, { grab: 6, backward: 0, ping: 3, pause: 9 });
});

test("keys and buttons have names for people", () => {
  assert.equal(moveName(DEFAULTS.keys[0]), "W A S D");
  assert.equal(moveName(DEFAULTS.keys[1]), "↑ ← ↓ →");
  assert.deepEqual(["Digit4", "Numpad8", "ShiftLeft", "F5"].map(keyName), ["4", "Num 8", "Left Shift", "F5"]);
  assert.deepEqual([buttonName(0), buttonName(6), buttonName(20)], ["A", "LT", "button 21"]);
});

test("every action has a name, and no default key or button does two things", () => {
  for (const action of [...KEY_ACTIONS, ...BUTTON_ACTIONS]) assert.ok(has(`play.settings.action.${action}`), action);
  const keys = DEFAULTS.keys.flatMap((set) => Object.values(set));
  const buttons = Object.values(DEFAULTS.buttons);
  assert.deepEqual([new Set(keys).size, new Set(buttons).size], [keys.length, buttons.length]);
});

test("what a key does already is known before it is given to another action", () => {
  const mapping = structuredClone(DEFAULTS);
  assert.deepEqual(useOfKey(mapping, "Enter", 0, "grab"), { set: 1, action: "grab" });
  assert.deepEqual(useOfKey(mapping, "KeyW", 0, "grab"), { set: 0, action: "up" });
  assert.equal(useOfKey(mapping, "Space", 0, "grab"), null);
  assert.equal(useOfKey(mapping, "KeyQ", 0, "grab"), null);
  assert.equal(useOfButton(mapping, 9, "grab"), "pause");
  assert.equal(useOfButton(mapping, 0, "grab"), null);
});
