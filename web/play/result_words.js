// @ts-check
/*
 * How a round ended, in words for people. The four measures are the paper's (appendix "Details of Evaluation
 * Metrics"): TCR and NFD are shares of 0 to 1, WT is in seconds, AC in 0 to 1 or -1 when nobody carried together.
 */

import { secondsOf } from "../core/ticks.js";
import { say, sayNumber } from "../text/catalogue.js";

const OUTCOMES = ["delivered", "time", "left", "stopped"];

/**
 * @typedef {object} Result the server's `result` message
 * @property {number} index
 * @property {string} outcome delivered | time | left | stopped | error
 * @property {number} ticks
 * @property {number} delivered
 * @property {number} items
 * @property {number} tcr
 * @property {number} nfd
 * @property {number} wt_s
 * @property {number} ac
 * @property {string} recording
 */
/** @typedef {{id: string, name: string, short: string, value: string, help: string}} Measure */

/**
 * @param {Pick<Result, "outcome">} result
 * @param {boolean} [byYou] the reader has stopped the round
 */
export function headline({ outcome }, byYou = false) {
  if (byYou && outcome !== "delivered") return say("play.result.headline.byYou");
  return say(`play.result.headline.${OUTCOMES.includes(outcome) ? outcome : "error"}`);
}

/** @param {number} ticks */
export function duration(ticks) {
  const seconds = secondsOf(ticks);
  if (seconds < 60) return say("play.result.seconds", { seconds: sayNumber(seconds, 1) });
  const whole = Math.round(seconds);
  return say("play.result.minutes", { minutes: Math.floor(whole / 60), seconds: whole % 60 });
}

/** @param {Pick<Result, "tcr" | "nfd" | "wt_s" | "ac">} result @returns {Measure[]} */
export function measures({ tcr, nfd, wt_s, ac }) {
  return [
    measure("tcr", percent(tcr)),
    measure("nfd", percent(nfd), nfd < 0 ? "farther" : "help"),
    measure("wt", say("play.result.seconds", { seconds: sayNumber(wt_s, 1) })),
    measure("ac", ac < 0 ? "–" : percent(ac), ac < 0 ? "none" : "help"),
  ];
}

/** @param {string} id @param {string} value @param {string} [help] which explanation */
function measure(id, value, help = "help") {
  const name = say(`play.measure.${id}`);
  return { id, name, short: id.toUpperCase(), value, help: say(`play.measure.${id}.${help}`) };
}

/** @param {number} share usually 0 to 1 */
export function percent(share) {
  const whole = Math.round(100 * share);
  return `${whole < 0 ? "\u2212" : ""}${Math.abs(whole)} %`;
}
