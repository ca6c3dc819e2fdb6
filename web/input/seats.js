// Which device drives which seat of this page, and what each seat's input is right now.
// One person: every device drives the one seat. Two people at one screen: blue has the first key set, red the
// second; a gamepad that is used goes to the seat that it drove before, else to the first seat without one; when only
// one seat has a gamepad, both key sets drive the other.

import { CENTRED, strongest } from "./stick.js";

/** @typedef {import("./mapping.js").Mapping} Mapping */
/** @typedef {import("./mapping.js").KeySet} KeySet */
/** @typedef {import("./keyboard.js").Reading} Reading */
/** @typedef {import("./gamepad.js").PadReading} PadReading */
/** @typedef {"keyboard" | "gamepad" | "touch"} Device */
/** @typedef {Reading & {device: Device}} SeatReading */
/**
 * What drives a seat, for people to read.
 * @typedef {{seat: number, keySets: number[], pad: PadName | null, device: Device}} SeatCard
 */
/** @typedef {{index: number, id: string}} PadName */
/**
 * @typedef {{get(seat: number): PadName | undefined, set(seat: number, pad: PadName | undefined): unknown}} PadMemory
 */
/**
 * @typedef {object} Devices
 * @property {{read(keys: KeySet): Reading, isUsed(keys: KeySet): boolean}} keyboard
 * @property {{read(mapping: Mapping): PadReading[]}} gamepads
 * @property {{read(): Reading, readonly used: boolean}} touch
 */

export class LocalSeats {
  /** @type {number[]} */
  #seats = [];
  /** @type {Map<number, PadName>} seat -> pad, when two people sit here */
  #pads = new Map();
  /** @type {Map<number, number>} seat -> index of the pad that drove it last */
  #padOf = new Map();
  /** @type {Map<number, Device>} */
  #device = new Map();
  #swapped = false;
  /** @type {Devices} */
  #devices;
  /** @type {Device} */
  #firstDevice;
  /** @type {number[]} seats whose pause button was pressed since the reading before */
  pauses = [];
  /** @type {number[]} seats whose gamepad, in use at the reading before, is gone */
  padsLost = [];
  /** Gamepads at the last reading. */
  padsPresent = 0;
  /** @type {number[]} seats whose own gamepad, of two people, was there at the last reading */
  padsOwned = [];

  /** @type {PadMemory} which pad drove a seat last, also after it was unplugged */
  #memory;

  /**
   * @param {Devices} devices
   * @param {Device} firstDevice  what is shown before anything was used
   * @param {PadMemory} [memory]
   */
  constructor(devices, firstDevice, memory = new Map()) {
    this.#devices = devices;
    this.#firstDevice = firstDevice;
    this.#memory = memory;
  }

  /** @param {readonly number[]} seats  the seats that this page holds: none, one or both */
  hold(seats) {
    this.#seats = [...seats].sort();
    if (this.#seats.length < 2) this.#pads.clear();
  }

  /** Fingers drive one seat, also of two people. */
  get #touchSeat() {
    return this.#seats[0];
  }

  /** Two people swap seats. */
  swap() {
    this.#swapped = !this.#swapped;
    exchange(this.#pads);
    exchange(this.#padOf);
    exchange(this.#device);
    const [blue, red] = [this.#memory.get(0), this.#memory.get(1)];
    this.#memory.set(0, red);
    this.#memory.set(1, blue);
  }

  /** Reads every device once. @param {Mapping} mapping @returns {Map<number, SeatReading>} by seat */
  read(mapping) {
    const pads = this.#devices.gamepads.read(mapping);
    this.padsPresent = pads.length;
    this.padsLost = this.#forgetLost(pads);
    this.padsOwned = this.#seats.filter((seat) => pads.some((pad) => this.#ownerOf(pad, pads) === seat));
    if (this.#seats.length > 1) this.#assign(pads);
    this.pauses = this.#seats.filter((seat) => pads.some((pad) => pad.pauses > 0 && this.#drives(pad, seat)));
    return new Map(
      this.#seats.map((seat) => {
        const sources = [
          ...this.#readKeys(seat, mapping),
          ...this.#readPads(seat, pads),
          ...(seat === this.#touchSeat ? [this.#readTouch()] : []),
        ];
        return [seat, this.#combine(seat, sources)];
      }),
    );
  }

  /** What drives each seat, for the cards beside the arena. @returns {SeatCard[]} */
  cards() {
    return this.#seats.map((seat) => ({
      seat,
      keySets: this.#keySetsOf(seat),
      pad: this.#pads.get(seat) ?? null,
      device: this.#deviceOf(seat),
    }));
  }

  /** Seats whose gamepad was unplugged have none. @param {readonly PadReading[]} pads @returns {number[]} which */
  #forgetLost(pads) {
    const driven = this.#seats.filter((seat) => this.#deviceOf(seat) === "gamepad");
    const lost = driven.filter((seat) => !pads.some((pad) => pad.index === this.#padOf.get(seat)));
    for (const seat of lost) {
      for (const known of [this.#pads, this.#padOf, this.#device]) known.delete(seat);
    }
    return lost;
  }

  /** @param {readonly PadReading[]} pads */
  #assign(pads) {
    for (const pad of pads) {
      if (!pad.active || [...this.#pads.values()].some((known) => known.index === pad.index)) continue;
      const seat = this.#seatFor(pad, pads);
      if (seat !== undefined) this.#give(seat, { index: pad.index, id: pad.id });
    }
  }

  /**
   * Of the seats without a pad: the pad's own, else one that waits for no other pad.
   * @param {PadReading} pad @param {readonly PadReading[]} pads
   */
  #seatFor(pad, pads) {
    const free = this.#seats.filter((seat) => !this.#pads.has(seat));
    const own = free.find((seat) => this.#ownerOf(pad, pads) === seat);
    return own ?? free.find((seat) => !pads.some((other) => this.#ownerOf(other, pads) === seat)) ?? free[0];
  }

  /**
   * The seat that had this gamepad last. One that slept or was unplugged may come back with another index: then it is
   * told by its model, where only one seat had such a one.
   * @param {PadReading} pad @param {readonly PadReading[]} pads
   */
  #ownerOf(pad, pads) {
    const [same] = this.#seats.filter((seat) => this.#drove(seat, pad));
    const [alike, another] = this.#seats.filter((seat) => this.#memory.get(seat)?.id === pad.id);
    const isThere = pads.some((other) => this.#drove(alike, other));
    return same ?? (another === undefined && !isThere ? alike : undefined);
  }

  /** Whether the seat had this gamepad last, under this index. @param {number} seat @param {PadReading} pad */
  #drove(seat, { index, id }) {
    const known = this.#memory.get(seat);
    return known?.index === index && known.id === id;
  }

  /** @param {number} seat @param {PadName} pad */
  #give(seat, pad) {
    this.#pads.set(seat, pad);
    this.#padOf.set(seat, pad.index);
    this.#memory.set(seat, pad);
  }

  /** @param {PadReading} pad @param {number} seat */
  #drives(pad, seat) {
    return this.#seats.length === 1 || this.#pads.get(seat)?.index === pad.index;
  }

  /** @param {number} seat @returns {number[]} */
  #keySetsOf(seat) {
    if (this.#seats.length === 1) return [0, 1];
    const partnerHasPad = this.#pads.has(1 - seat);
    if (partnerHasPad && !this.#pads.has(seat)) return [0, 1];
    if (this.#pads.has(seat) && !partnerHasPad) return [];
    return [this.#swapped ? 1 - seat : seat];
  }

  /** @param {number} seat @param {Mapping} mapping */
  #readKeys(seat, mapping) {
    return this.#keySetsOf(seat).map((set) => {
      const used = this.#devices.keyboard.isUsed(mapping.keys[set]);
      return source("keyboard", this.#devices.keyboard.read(mapping.keys[set]), used);
    });
  }

  /** @param {number} seat @param {readonly PadReading[]} pads */
  #readPads(seat, pads) {
    const mine = pads.filter((pad) => this.#drives(pad, seat));
    const used = mine.find(({ active }) => active);
    if (used) this.#padOf.set(seat, used.index);
    return mine.map((pad) => source("gamepad", pad, pad.active));
  }

  #readTouch() {
    const used = this.#devices.touch.used;
    return source("touch", this.#devices.touch.read(), used);
  }

  /** @param {number} seat @param {(Reading & {device: Device, used: boolean})[]} sources @returns {SeatReading} */
  #combine(seat, sources) {
    const used = sources.find((one) => one.used);
    if (used) this.#device.set(seat, used.device);
    return {
      stick: strongest([CENTRED, ...sources.map((one) => one.stick)]),
      backward: sources.some((one) => one.backward),
      grabs: sources.reduce((sum, one) => sum + one.grabs, 0),
      pings: sources.reduce((sum, one) => sum + one.pings, 0),
      device: this.#deviceOf(seat),
    };
  }

  /** @param {number} seat @returns {Device} */
  #deviceOf(seat) {
    if (this.#pads.has(seat)) return "gamepad";
    const first = seat === this.#touchSeat || this.#firstDevice !== "touch" ? this.#firstDevice : "keyboard";
    return this.#device.get(seat) ?? first;
  }
}

/** What is known of one seat becomes that of the other. @template Value @param {Map<number, Value>} known */
function exchange(known) {
  const entries = [...known];
  known.clear();
  for (const [seat, value] of entries) known.set(1 - seat, value);
}

/** @param {Device} device @param {Reading} reading @param {boolean} used */
function source(device, reading, used) {
  return { ...reading, device, used };
}
