// @ts-check
/*
 * Gamepads that somebody played with and that are gone: when a round pauses for them, in whose name, and what a pause
 * says, also one that was on before.
 */

import { say } from "../text/catalogue.js";
import { colourName } from "../text/names.js";

export class LostPads {
  #pauses = false; // the pause that is on began with a gamepad that is gone
  #wanted = 0; // how many gamepads there were before that
  #present = 0;
  /** @type {readonly number[]} whose were lost, in the round and in the pause that followed */
  #seats = [];
  /** @type {readonly number[]} whose own are there */
  #owned = [];

  /**
   * After each reading of the devices.
   * @param {{padsLost: readonly number[], padsPresent: number, padsOwned: readonly number[]}} devices
   * @param {string} phase
   * @returns {number | null} the seat for which to pause now
   */
  update({ padsLost, padsPresent, padsOwned }, phase) {
    if (phase === "countdown" && this.#pauses) this.forget(); // also where nobody here has said so
    this.#present = padsPresent;
    this.#owned = padsOwned;
    if (padsLost.length > 0 && ["countdown", "playing", "paused"].includes(phase)) {
      const before = this.#pauses ? this.#seats : this.#missing ? this.#gone : [];
      this.#seats = [...new Set([...before, ...padsLost])];
      this.#wanted = Math.max(before.length > 0 ? this.#wanted : 0, padsPresent + padsLost.length);
    }
    if (phase !== "playing" || this.#pauses || !this.#missing) return null;
    this.#pauses = true;
    return this.#gone[0] ?? this.#seats[0];
  }

  get #missing() {
    return this.#present < this.#wanted;
  }

  /** Whose are lost and not back; with one person at the screen it is theirs in any case. */
  get #gone() {
    return this.#seats.filter((seat) => !this.#owned.includes(seat));
  }

  /** Play goes on. */
  forget() {
    this.#pauses = false;
    this.#wanted = 0;
  }

  /** For the pause; with two people at the screen it says whose. @param {readonly number[]} own */
  hint(own) {
    if (!this.#pauses && !this.#missing) return "";
    const missing = this.#wanted - this.#present;
    if (this.#missing) return padText("padLost", own, this.#gone.length === missing ? this.#gone : []);
    return padText("padBack", own, this.#seats);
  }
}

/**
 * @param {"padLost" | "padBack"} what @param {readonly number[]} own
 * @param {readonly number[]} seats whose gamepad it is; none where that is unknown
 */
function padText(what, own, seats) {
  if (own.length > 1 && seats.length === 2) return say(`play.pause.${what}Both`);
  if (own.length > 1 && seats.length === 1) return say(`play.pause.${what}By`, { colour: colourName(seats[0]) });
  return say(`play.pause.${what}`);
}
