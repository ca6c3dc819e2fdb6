// When an input frame goes out: at once on an edge, a moving stick at most 25 times a second, else 20 times a second
// (the server treats a stick without news for half a second as released). Only the newest is ever sent.

import { DEVICES } from "../messages.js";
import { CENTRED, driveFrom } from "./stick.js";

/** @typedef {import("../messages.js").Input} Input */
/** @typedef {import("./seats.js").SeatReading} SeatReading */
/** @typedef {{ackTick: number, seenTick: number}} Seen */

const ANALOGUE_MS = 40;
const KEEP_ALIVE_MS = 50;
const TURN = 0.01; // rad and share of the stick below which a change is noise

/** The input frames of one seat over one socket. */
export class InputSender {
  #seat;
  #seq = 0;
  #grabs = 0;
  /** @type {Input | null} */
  #last = null;
  #heading;

  /** @param {number} seat @param {number} heading  where the robot looks at the start, rad */
  constructor(seat, heading = 0) {
    this.#seat = seat;
    this.#heading = heading;
  }

  /**
   * The frame to send now, or null. Presses are never lost: they are counted into the next frame.
   * @param {number} nowMs @param {SeatReading} reading @param {Seen} seen @returns {Input | null}
   */
  next(nowMs, reading, seen) {
    const { move, heading } = driveFrom(reading.stick, reading.backward, this.#heading);
    this.#heading = heading;
    this.#grabs = (this.#grabs + reading.grabs) % 256;
    const input = {
      seat: this.#seat,
      seq: this.#seq + 1,
      ...seen,
      move,
      heading,
      grabs: this.#grabs,
      device: DEVICES.indexOf(reading.device),
      clientMs: nowMs,
    };
    if (nowMs - (this.#last?.clientMs ?? -Infinity) < this.#pauseAfter(input)) return null;
    this.#seq += 1;
    this.#last = input;
    return input;
  }

  /**
   * Releases everything at once: the page is hidden.
   * @param {number} nowMs
   * @param {Seen} seen
   * @returns {Input}
   */
  neutral(nowMs, seen) {
    this.#seq += 1;
    this.#last = {
      seat: this.#seat,
      seq: this.#seq,
      ...seen,
      move: 0,
      heading: this.#heading,
      grabs: this.#grabs,
      device: this.#last?.device ?? 0,
      clientMs: nowMs,
    };
    return this.#last;
  }

  /** What the device says when nothing is pressed. @returns {SeatReading} */
  get released() {
    const device = /** @type {SeatReading["device"]} */ (DEVICES[this.#last?.device ?? 0]);
    return { stick: CENTRED, backward: false, grabs: 0, pings: 0, device };
  }

  /** How long after the last frame this one may go out. @param {Input} input */
  #pauseAfter(input) {
    const last = this.#last;
    if (last === null || input.grabs !== last.grabs) return 0;
    const sameDrive = Math.abs(input.move - last.move) < TURN && Math.abs(input.heading - last.heading) < TURN;
    if (sameDrive && (input.move === 0) === (last.move === 0)) return KEEP_ALIVE_MS;
    const analogue = DEVICES[input.device] !== "keyboard" && input.move !== 0 && last.move !== 0;
    return analogue ? ANALOGUE_MS : 0;
  }
}

/** The input frames of all seats of a page: what their devices say, or neutral input. */
export class InputSenders {
  /** @type {Map<number, InputSender>} */
  #senders = new Map();
  #send;
  #seen;

  /**
   * @param {(input: Input) => void} send
   * @param {() => Seen} seen the newest tick received and the newest shown
   */
  constructor(send, seen) {
    this.#send = send;
    this.#seen = seen;
  }

  /** @param {readonly number[]} seats those of this page from now on */
  hold(seats) {
    this.#senders = new Map(seats.map((seat) => [seat, new InputSender(seat)]));
  }

  /** @param {number} seat @param {SeatReading} reading @param {number} nowMs */
  send(seat, reading, nowMs) {
    const input = this.#senders.get(seat)?.next(nowMs, reading, this.#seen());
    if (input) this.#send(input);
  }

  /** Neutral input for as long as this is called, no more often than any other. @param {number} nowMs */
  keepNeutral(nowMs) {
    for (const [seat, sender] of this.#senders) this.send(seat, sender.released, nowMs);
  }

  /** Neutral input at once. @param {number} nowMs */
  sendNeutral(nowMs) {
    for (const sender of this.#senders.values()) this.#send(sender.neutral(nowMs, this.#seen()));
  }
}
