// @ts-check
/*
 * The screen of each kind of step.
 */

import { consentScreen } from "./consent.js";
import { codeScreen, debriefScreen } from "./ending.js";
import { formScreen } from "./form_screen.js";
import { inputCheckScreen } from "./input_check/input_check.js";
import { breakScreen, elsewhereScreen, pausedScreen, waitingScreen } from "./pauses.js";
import { roundScreen } from "./round.js";

/** @typedef {import("./screen.js").Context} Context */
/** @typedef {import("./screen.js").Screen} Screen */

export const SCREENS = /** @type {Record<string, (context: Context) => Screen>} */ ({
  consent: consentScreen,
  form: formScreen,
  questionnaire: formScreen,
  "input-check": inputCheckScreen,
  practice: roundScreen,
  round: roundScreen,
  waiting: waitingScreen,
  break: breakScreen,
  paused: pausedScreen,
  debrief: debriefScreen,
  code: codeScreen,
  "ended-elsewhere": elsewhereScreen,
});
