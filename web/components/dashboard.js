// @ts-check
/*
 * What the pages that watch a running server share: coloured words, cards with figures, and how figures are written.
 */

import { el } from "../core/dom.js";
import { roundTripTone } from "../core/round_trip.js";
import { say, sayNumber } from "../text/catalogue.js";

/** @typedef {"" | "ok" | "attention" | "bad"} Tone */
/** @typedef {{words: string, tone: Tone}} Pill */
/** @typedef {{title: string, value: string, detail: string, tone: "" | "bad"}} Fact */

/** Where there is nothing to say. @type {Pill} */
export const NO_PILL = Object.freeze({ words: "–", tone: "" });

const LATE_MS = 25; // p99 lateness of ticks, a quarter of one: earlier the pictures hide it (EXTRAPOLATE_MS is 60)
const MISSED_SHARE = 0.001; // of the ticks; less than one in a round of 50 s goes unnoticed
const DISK_MB = 1000; // less free than this is too little

/** @param {Pill} pill */
export function pill({ words, tone }) {
  if (words === NO_PILL.words) return el("span", { class: "muted" }, words);
  return el("span", { class: `pill ${tone && `pill-${tone}`}` }, words);
}

/** A second line in a cell; none for an empty text. @param {string} text */
export function remark(text) {
  return text ? [el("span", { class: "room-remark" }, text)] : [];
}

/** @param {HTMLElement} list a <dl> @param {readonly Fact[]} facts */
export function showFacts(list, facts) {
  const cards = facts.map(({ title, value, detail, tone }) =>
    el(
      "div",
      { class: "card fact", "data-tone": tone },
      el("dt", {}, title),
      el("dd", { class: "fact-value" }, value),
      el("dd", { class: "fact-detail" }, detail),
    ),
  );
  list.replaceChildren(...cards);
}

/** How long a message takes to a player and back. @param {number} rttMs @returns {Pill} */
export function roundTripPill(rttMs) {
  return { words: milliseconds(rttMs, 0), tone: roundTripTone(rttMs) };
}

/** Whether ticks are so late that a person might notice. @param {number} ms */
export function isLate(ms) {
  return ms > LATE_MS;
}

/**
 * Whether so many ticks were missed that a person might notice.
 * @param {number} missed @param {number} ticks
 */
export function missesMany(missed, ticks) {
  return missed > MISSED_SHARE * ticks;
}

/** @param {number} megabytes @returns {{value: string, tone: "" | "bad"}} */
export function freeDisk(megabytes) {
  const value =
    megabytes < 10_000
      ? say("dashboard.megabytes", { count: Math.round(megabytes) })
      : say("dashboard.gigabytes", { count: Math.round(megabytes / 1000) });
  return { value, tone: megabytes < DISK_MB ? "bad" : "" };
}

/** @param {number} ms @param {number} decimals */
export function milliseconds(ms, decimals) {
  return say("dashboard.milliseconds", { ms: sayNumber(ms, decimals) });
}
