// @ts-check
/*
 * How a round ended, in words for people. Pure. The four measures are the paper's (appendix "Details of Evaluation
 * Metrics"): TCR and NFD are shares of 0 to 1, WT is in seconds, AC in 0 to 1 or -1 when nobody carried together.
 */

import { secondsOf } from "../core/ticks.js";

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

/** @param {Pick<Result, "outcome">} result */
export function headline({ outcome }) {
  if (outcome === "delivered") return "Everything is delivered!";
  if (outcome === "time") return "Time is up";
  if (outcome === "left") return "The round ended: a player left";
  if (outcome === "stopped") return "The round was stopped";
  return "The round ended with a fault";
}

/** @param {number} ticks */
export function duration(ticks) {
  const seconds = secondsOf(ticks);
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

/** @param {Pick<Result, "tcr" | "nfd" | "wt_s" | "ac">} result @returns {Measure[]} */
export function measures({ tcr, nfd, wt_s, ac }) {
  return [
    {
      id: "tcr",
      name: "Work done",
      short: "TCR",
      value: percent(tcr),
      help: "delivered; middle and large items count twice",
    },
    {
      id: "nfd",
      name: "Brought closer",
      short: "NFD",
      value: percent(nfd),
      help: nfd < 0 ? "items ended farther from the goal" : "of all the way to the goal",
    },
    { id: "wt", name: "Waiting", short: "WT", value: `${wt_s.toFixed(1)} s`, help: "holding an item until help came" },
    {
      id: "ac",
      name: "Pulling together",
      short: "AC",
      value: ac < 0 ? "–" : percent(ac),
      help: ac < 0 ? "nothing was carried together" : "the same way while carrying together",
    },
  ];
}

/** @param {number} share usually 0 to 1 */
export function percent(share) {
  const whole = Math.round(100 * share);
  return `${whole < 0 ? "\u2212" : ""}${Math.abs(whole)} %`;
}
