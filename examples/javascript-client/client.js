/**
 * A client for programs that take a seat on a running Moving Out Live server: states in, chunks of actions out.
 *
 *     const client = await Client.connect("http://127.0.0.1:8000", room);
 *     for await (const state of client.states()) client.act([[1, Math.cos(0), Math.sin(0), 0]]);
 */

/** @typedef {{x: number, y: number, angle: number}} Pose in units of the world; angle in radians, 0 is up */
/** @typedef {{tick: number, seat: number, item: number, x: number, y: number}} Ping who asks for help with which item, -1 at x, y; first seen in `tick` */
/** @typedef {{tick: number, robots: Pose[], items: Pose[], held: number[], pings: Ping[]}} State after `tick`; index 0 is blue, -1 holds nothing */
/** @typedef {[distance: number, cos: number, sin: number, grasp: number]} Row one tick of actions; grasp 1 presses */
/** @typedef {{outcome: string, ticks: number, metrics: Record<string, number>, recording: string}} Result */
/** @typedef {{name?: string, token?: string, WebSocket?: typeof globalThis.WebSocket}} Options */

const SIZES = { B: 1, b: 1, H: 2, h: 2, I: 4, d: 8 };
/** @type {Record<string, ["getUint8", "setUint8"] | any>} */
const ACCESS = { B: "Uint8", b: "Int8", H: "Uint16", h: "Int16", I: "Uint32", d: "Float64" };
const [BUNDLE, INPUT, PROGRAM] = [1, 3, 3];
const OVER = ["series_over", "closed"]; // phases without a further round

/** The server refuses, or has closed the connection; the message is the server's. */
export class RemoteError extends Error {
  name = "RemoteError";
}

/** One seat in one room, for a series of rounds. */
export class Client {
  /** 0 blue, 1 red. @type {number} */ seat = -1;
  /** Of this seat: with it a later connection comes back. @type {string} */ token = "";
  /** The map of the coming or running round, as JSON (docs/maps.md). @type {any} */ map = null;
  /** Of the last round. @type {Result | null} */ result = null;
  /** @type {State | null} */ #newest = null;
  /** @type {Row[]} */ #rows = [];
  /** @type {(Ping & {ticks: number})[]} */ #pings = [];
  /** @type {() => void} */ #wake = () => {};
  #fresh = false;
  #closed = "";
  #phase = "";
  #reason = "";
  #refused = "";
  #epoch = 0;
  #seq = 0;
  #grabs = 0;
  #silent = false;
  /** @type {any} */ #frames = {};
  /** @type {WebSocket} */ #socket;

  /** @param {WebSocket} socket use `Client.connect` */
  constructor(socket) {
    this.#socket = socket;
  }

  /**
   * Take an open seat for a program.
   * @param {string} server address, http(s) or ws(s)
   * @param {string} room
   * @param {Options} [options] `token`: of an earlier connection; `WebSocket`: where there is none (Node before 22)
   * @returns {Promise<Client>}
   */
  static async connect(server, room, { name = "program", token = "", WebSocket = globalThis.WebSocket } = {}) {
    if (!WebSocket) throw new RemoteError("there is no WebSocket here; pass one, such as that of the package ws");
    if (!/^(http|ws)s?:\/\/[^/]/.test(server))
      throw new RemoteError(`'${server}' is no address of a server; write http://127.0.0.1:8000`);
    const address = new URL(server.replace(/^http/, "ws"));
    address.pathname = `${address.pathname.replace(/\/(ws)?$/, "")}/ws/${encodeURIComponent(room)}`;
    const socket = new WebSocket(address, ["movingout.v1"]);
    socket.binaryType = "arraybuffer";
    const client = new Client(socket);
    await client.#join({ room, name, program: true, ...(token ? { tokens: [token] } : { claim: 1 }) }, address.href);
    return client;
  }

  /**
   * Say ready, and give the newest state, ten a second, until the round ends; `result` tells how. Throws a RemoteError
   * when the server refuses or closes the connection, or the series ends without a result.
   * @returns {AsyncGenerator<State>}
   */
  async *states() {
    [this.result, this.#newest, this.#rows, this.#fresh, this.#refused] = [null, null, [], false, ""];
    this.#tell({ type: "ready", seat: this.seat });
    while (!this.#ended()) {
      if (!this.#fresh) await new Promise((resolve) => (this.#wake = () => resolve(undefined)));
      this.#fresh = false;
      if (!this.result && !this.over && this.#newest) yield this.#newest;
    }
  }

  /** Whether the series has no further round. */
  get over() {
    return this.#closed !== "" || OVER.includes(this.#phase);
  }

  /** Whether the round is over and the room has said what follows. Throws when no result will come. */
  #ended() {
    if (this.result) return this.#phase !== "" || this.#closed !== "";
    const why = this.#closed || this.#refused || (this.over && (this.#reason || "the series is over"));
    if (why) throw new RemoteError(why);
    return false;
  }

  /**
   * Play rows from now on, one per tick; they replace the rest of the last chunk. A press that was sent is not taken back.
   * @param {Row[]} rows
   */
  act(rows) {
    if (
      !Array.isArray(rows) ||
      !rows.length ||
      !rows.every((row) => row?.length === 4 && [...row].every(Number.isFinite))
    )
      throw new RemoteError("a chunk is rows of four numbers: distance, cos and sin of the heading, grasp");
    [this.#rows, this.#silent] = [[...rows], false];
    this.#send();
  }

  close() {
    this.#socket.close();
  }

  /** @param {object} join @param {string} address */
  #join(join, address) {
    return new Promise((resolve, reject) => {
      this.#socket.onopen = () => this.#tell({ type: "join", ...join });
      this.#socket.onerror = () => reject(new RemoteError(`cannot connect to ${address}`));
      this.#socket.onclose = () => {
        this.#closed ||= "the server has closed the connection";
        reject(new RemoteError(this.#closed));
        this.#notify();
      };
      this.#socket.onmessage = ({ data }) => {
        if (typeof data !== "string") return this.#takeBundle(new DataView(data));
        const message = JSON.parse(data);
        if (message.type === "welcome" && message.seats.length) {
          [this.seat, this.token, this.#frames] = [message.seats[0].seat, message.seats[0].token, message.frames];
          resolve(undefined);
        } else this.#take(message);
      };
    });
  }

  /** @param {any} message */
  #take(message) {
    if (message.type === "round") [this.map, this.#epoch, this.#pings] = [message.map, message.epoch, []];
    if (message.type === "ping" && message.epoch === this.#epoch) this.#pings.push(message);
    if (message.type === "bye") this.#closed = message.message;
    if (message.type === "room") {
      [this.#phase, this.#reason] = [message.phase, message.reason];
      if (this.result || this.over) this.#notify();
    }
    if (message.type === "error" && this.#phase !== "playing") {
      this.#refused = message.message; // in a round that runs, nobody needs to be ready
      this.#notify();
    }
    // `room` follows a result, and says whether another round does.
    if (message.type === "result") [this.result, this.#phase] = [message, ""];
  }

  /** @param {DataView} view */
  #takeBundle(view) {
    if (view.getUint8(0) !== BUNDLE) return;
    const [head, start] = read(this.#frames.bundle, view, 0);
    if (head.epoch !== this.#epoch % 65536) return;
    const poses = [];
    const size = sizeOf(this.#frames.pose);
    for (let body = 0; body < head.bodies; body++) {
      const [pose] = read(this.#frames.pose, view, start + ((head.pose_count - 1) * head.bodies + body) * size);
      poses.push({ x: pose.x / 20000, y: pose.y / 20000, angle: (pose.angle * Math.PI) / 32768 });
    }
    const held = [head.held_blue, head.held_red];
    this.#pings = this.#pings.filter((ping) => head.tick < ping.tick + ping.ticks);
    const pings = this.#pings.map(({ tick, seat, item, x, y }) => ({ tick, seat, item, x, y }));
    this.#newest = { tick: head.tick, robots: poses.slice(0, 2), items: poses.slice(2), held, pings };
    const unanswered = this.#silent;
    this.#silent = true;
    if (this.#rows.length || unanswered) this.#send();
    this.#notify();
  }

  #send() {
    const still = this.#newest?.robots[this.seat].angle ?? 0;
    const [distance, cos, sin, grasp] = this.#rows.shift() ?? [0, Math.cos(still), Math.sin(still), 0];
    const tick = this.#newest?.tick ?? 0;
    if (grasp > 0.5) this.#grabs++;
    const heading = Math.round((Math.atan2(sin, cos) * 32768) / Math.PI); // 32768 wraps to -32768: half a turn
    const move = Math.round(Math.max(-1, Math.min(1, distance)) * 32767);
    const values = { type: INPUT, seat: this.seat, seq: ++this.#seq, ack_tick: tick, seen_tick: tick, move, heading };
    const frame = write(this.#frames.input, { ...values, grabs: this.#grabs % 256, device: PROGRAM });
    if (this.#socket.readyState === 1) this.#socket.send(frame);
  }

  /** @param {object} message */
  #tell(message) {
    if (this.#socket.readyState === 1) this.#socket.send(JSON.stringify(message));
  }

  #notify() {
    this.#fresh = true;
    this.#wake();
  }
}

/** @typedef {{format: string, names: string[]}} Frame as the server declares it */

/** @param {Frame} frame @returns {(keyof typeof SIZES)[]} */
const letters = (frame) => /** @type {any} */ ([...frame.format.replace("<", "")]);

/** @param {Frame} frame */
const sizeOf = (frame) => letters(frame).reduce((size, letter) => size + SIZES[letter], 0);

/** @param {Frame} frame @param {DataView} view @param {number} at @returns {[Record<string, number>, number]} */
function read(frame, view, at) {
  /** @type {Record<string, number>} */
  const values = {};
  letters(frame).forEach((letter, index) => {
    values[frame.names[index]] = /** @type {any} */ (view)[`get${ACCESS[letter]}`](at, true);
    at += SIZES[letter];
  });
  return [values, at];
}

/** @param {Frame} frame @param {Record<string, number>} values */
function write(frame, values) {
  const view = new DataView(new ArrayBuffer(sizeOf(frame)));
  let at = 0;
  letters(frame).forEach((letter, index) => {
    /** @type {any} */ (view)[`set${ACCESS[letter]}`](at, values[frame.names[index]] ?? 0, true);
    at += SIZES[letter];
  });
  return view.buffer;
}
