// @ts-check
/*
 * What somebody has set in this browser for themselves. Everybody in a study begins with the same keys and with sound;
 * who comes back to their place finds what they have set.
 */

import { forgetSound } from "../core/sound_choice.js";
import { forgetKeySet, forgetMapping } from "../input/mapping.js";
import { PadMemory, STUDY_PADS, forgetPads } from "../input/pad_memory.js";

/**
 * Somebody new sits here: keys, buttons, the dead zone, sound and gamepads are no longer those of whoever came before.
 * @param {() => Pick<Storage, "removeItem">} [lasting]
 * @param {() => Pick<Storage, "removeItem">} [ofTab]
 */
export function forgetSettings(lasting = () => localStorage, ofTab = () => sessionStorage) {
  try {
    forgetMapping(lasting());
    forgetSound(lasting());
    forgetPads(STUDY_PADS, ofTab());
  } catch {
    // without storage nobody has left anything
  }
}

/**
 * Somebody new sits beside the first person: the second keys and gamepad are no longer those of who sat there before.
 * @param {() => Storage} [lasting]
 * @param {() => Storage} [ofTab]
 */
export function forgetSecond(lasting = () => localStorage, ofTab = () => sessionStorage) {
  try {
    forgetKeySet(lasting(), 1);
    new PadMemory(STUDY_PADS, [0, 1], ofTab).set(1, undefined);
  } catch {
    // as above
  }
}
