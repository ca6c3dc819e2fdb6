// @ts-check
/*
 * Gamepads that somebody played with and that are gone: when a round pauses for them, in whose name, and what the pause
 * says.
 */

import { say } from "../text/catalogue.js";
import { colourName } from "../text/names.js";

export class LostPads {
  #pauses = false; // the pause that is on began with a gamepad that is gone
  #wanted = 0; // how many gamepads there were before that
  #present = 0;
  /** @type {readonly number[]} whose is gone */
  #seats = [];

  /**
   * After each reading of the devices.
   * @param {{padsLost: readonly number[], padsPresent: number}} devices @param {string} phase
   * @returns {number | null} the seat for which to pause now
   */
  update({ padsLost, padsPresent }, phase) {
    this.#present = padsPresent;
    if (padsLost.length > 0 && ["countdown", "playing"].includes(phase)) {
      this.#wanted = padsPresent + padsLost.length;
      this.#seats = padsLost;
    }
    if (phase !== "playing" || this.#pauses || !this.#missing) return null;
    this.#pauses = true;
    return this.#seats[0];
  }

  get #missing() {
    return this.#present < this.#wanted;
  }

  /** Play goes on. */
  forget() {
    this.#pauses = false;
    this.#wanted = 0;
  }

  /** For the pause; with two people at the screen it says whose. @param {readonly number[]} own */
  hint(own) {
    if (!this.#pauses) return "";
    const colour = own.length > 1 && this.#seats.length === 1 ? colourName(this.#seats[0]) : "";
    if (this.#missing) return colour ? say("play.pause.padLostBy", { colour }) : say("play.pause.padLost");
    return colour ? say("play.pause.padBackBy", { colour }) : say("play.pause.padBack");
  }
}
