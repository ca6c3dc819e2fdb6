// Sends the input of the seats of this page: what their devices say, or neutral input.

import { InputSender } from "../input/sender.js";

/** @typedef {import("../input/seats.js").SeatReading} SeatReading */
/** @typedef {import("../wire/connection.js").Connection} Connection */

export class OwnInputs {
  /** @type {Map<number, InputSender>} */
  #senders = new Map();

  /**
   * @param {Connection} connection
   * @param {() => {ackTick: number, seenTick: number}} seen the newest tick received and the newest shown
   */
  constructor(connection, seen) {
    this.connection = connection;
    this.seen = seen;
  }

  /** @param {readonly number[]} seats those of this page from now on */
  hold(seats) {
    this.#senders = new Map(seats.map((seat) => [seat, new InputSender(seat)]));
  }

  /** @param {number} seat @param {SeatReading} reading @param {number} nowMs */
  send(seat, reading, nowMs) {
    const input = this.#senders.get(seat)?.next(nowMs, reading, this.seen());
    if (input) this.connection.sendInput(input);
  }

  /** @param {number} nowMs */
  sendNeutral(nowMs) {
    for (const sender of this.#senders.values()) this.connection.sendInput(sender.neutral(nowMs, this.seen()));
  }
}
