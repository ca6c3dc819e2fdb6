// @ts-check
/*
 * The alerts at the top of the experimenter's screen. What was dismissed stays so in this tab.
 */

import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";
import { alertWords, atWords } from "./words.js";

/** @typedef {import("./words.js").Alert} Alert */

const DISMISSED = "movingout.experimenter.alerts";
const MOST = 3; // shown at once

export class Alerts {
  #dismissed = new Set(dismissedAlerts());
  /** @type {readonly Alert[]} */
  #alerts = [];

  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
  }

  /** The newest that were not dismissed. @param {readonly Alert[]} alerts */
  show(alerts) {
    this.#alerts = alerts;
    const open = alerts.filter((alert) => !this.#dismissed.has(nameOf(alert))).slice(0, MOST);
    const key = open.map(({ id }) => id).join();
    if (this.box.dataset.key === key) return;
    this.box.dataset.key = key;
    this.box.replaceChildren(...open.map((alert) => this.#notice(alert)));
  }

  /** @param {Alert} alert */
  #notice(alert) {
    const text = alertWords(alert);
    const dismiss = el(
      "button",
      { type: "button", class: "button button-small", "aria-label": say("experimenter.dismissThis", { text }) },
      say("experimenter.dismiss"),
    );
    dismiss.addEventListener("click", () => this.#dismiss(alert));
    return el(
      "div",
      { class: "notice notice-attention alert" },
      el("span", { class: "nowrap" }, atWords(alert.at)),
      el("span", {}, text, ...(alert.detail ? [" ", el("code", { class: "small" }, alert.detail)] : [])),
      dismiss,
    );
  }

  /** @param {Alert} alert */
  #dismiss(alert) {
    this.#dismissed.add(nameOf(alert));
    keepDismissed([...this.#dismissed]);
    this.show(this.#alerts);
  }
}

/** An alert that comes again at another time is another one. @param {Alert} alert */
function nameOf({ id, at }) {
  return `${id}-${at}`;
}

/** @returns {string[]} */
function dismissedAlerts() {
  try {
    const kept = JSON.parse(sessionStorage.getItem(DISMISSED) ?? "[]");
    return Array.isArray(kept) ? kept : [];
  } catch {
    return [];
  }
}

/** @param {string[]} alerts */
function keepDismissed(alerts) {
  try {
    sessionStorage.setItem(DISMISSED, JSON.stringify(alerts));
  } catch {
    // dismissed alerts come back after a reload
  }
}
