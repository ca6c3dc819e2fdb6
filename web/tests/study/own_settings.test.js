// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { keepSound, wantsSound } from "../../core/sound_choice.js";
import { DEFAULTS, loadMapping, saveMapping, withKey } from "../../input/mapping.js";
import { PadMemory, STUDY_PADS } from "../../input/pad_memory.js";
import { forgetSecond, forgetSettings } from "../../study/own_settings.js";

/** @returns {Storage} */
function storage() {
  /** @type {Map<string, string>} */
  const kept = new Map();
  return /** @type {any} */ ({
    getItem: (/** @type {string} */ key) => kept.get(key) ?? null,
    setItem: (/** @type {string} */ key, /** @type {string} */ value) => void kept.set(key, value),
    removeItem: (/** @type {string} */ key) => void kept.delete(key),
  });
}

test("somebody new has the keys, the sound and the gamepads that everybody begins with, and all else stays", () => {
  const [lasting, ofTab] = [storage(), storage()];
  Object.assign(globalThis, { localStorage: lasting, sessionStorage: ofTab });
  saveMapping(lasting, { ...withKey(structuredClone(DEFAULTS), 0, "grab", "KeyX"), deadZone: 0.15 });
  keepSound(false);
  new PadMemory(STUDY_PADS).set(0, { id: "pad", index: 1 });
  lasting.setItem("movingout.theme", "dark");
  forgetSettings();
  assert.deepEqual(loadMapping(lasting), DEFAULTS);
  assert.equal(wantsSound(), true);
  assert.equal(new PadMemory(STUDY_PADS).get(0), undefined);
  assert.equal(lasting.getItem("movingout.theme"), "dark");
});

test("somebody new beside the first person has the second keys that everybody begins with, and no gamepad", () => {
  const [lasting, ofTab] = [storage(), storage()];
  Object.assign(globalThis, { localStorage: lasting, sessionStorage: ofTab });
  const first = withKey(structuredClone(DEFAULTS), 0, "grab", "KeyX");
  saveMapping(lasting, { ...withKey(first, 1, "up", "KeyI"), deadZone: 0.15 });
  const pads = new PadMemory(STUDY_PADS);
  pads.set(0, { id: "pad", index: 1 });
  pads.set(1, { id: "pad", index: 2 });
  keepSound(false);
  forgetSecond();
  assert.deepEqual(loadMapping(lasting), { ...first, deadZone: 0.15 });
  assert.deepEqual(new PadMemory(STUDY_PADS).get(0), { id: "pad", index: 1 });
  assert.equal(new PadMemory(STUDY_PADS).get(1), undefined);
  assert.equal(wantsSound(), false, "it is heard by both");
  lasting.removeItem("movingout.mapping");
  forgetSecond();
  assert.deepEqual(loadMapping(lasting), DEFAULTS);
});

test("where no storage may be used, nobody has left anything", () => {
  const forbidden = () => {
    throw new Error("forbidden");
  };
  forgetSettings(forbidden, forbidden);
  forgetSecond(forbidden, forbidden);
});
