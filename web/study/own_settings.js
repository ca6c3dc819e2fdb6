// @ts-check
/*
 * What somebody has set in this browser for themselves. Everybody in a study begins with the same keys and with sound;
 * who comes back to their place finds what they have set.
 */

import { forgetSound } from "../core/sound_choice.js";
import { forgetMapping } from "../input/mapping.js";
import { STUDY_PADS, forgetPads } from "../input/pad_memory.js";

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
