// The socket to a room: joins with this tab's seats, measures the round trip, reconnects with back-off after a loss.
// Knows the wire and nothing of the game; what it hears goes to the listener.

import { requestJson } from "../core/api.js";
import { Elapsed } from "../core/elapsed.js";
import * as wire from "../messages.js";
import { leaveTokens, loadTokens, saveTokens, takeLeftTokens } from "./seat_tokens.js";
import { has, say } from "../text/catalogue.js";

/** @typedef {"connecting" | "open" | "reconnecting" | "over"} Status */
/**
 * @typedef {object} Listener
 * @property {(message: wire.ServerMessage, atMs: number) => void} onMessage
 * @property {(bundle: wire.Bundle, atMs: number) => void} onBundle
 * @property {(sentMs: number, serverMs: number, atMs: number) => void} onPong
 * @property {(status: Status, ending?: Ending, why?: string) => void} onStatus
 *   ending: why it is over, unless this page hung up; why: what the server said before it closed a connection that is
 *   tried again, a sentence for people
 */
/** @typedef {{kind: string, sentence: string}} Ending  kind: of ENDINGS, or a page's own; the sentence is for people */

const BACK_OFF_MS = { first: 100, last: 5000 };
const PING_MS = 1000;
const FIRST_PINGS = 5; // in quick succession, to know the clock at once
const FIRST_PING_MS = 60;
const SILENT_MS = 5000; // the server says something every second; so long without a word and the line is dead
const HANDSHAKE_MS = 2 * SILENT_MS; // a slow line opens within this; an unanswered handshake would last for minutes
const FAILED_TRIES = 3; // handshakes that failed in a row before the page asks why
const ANSWERS = 3; // and this often the server knew the room: only its live connection fails
/** The codes with which the server closes for good. @type {Readonly<Record<number, string>>} */
const ENDINGS = Object.freeze({
  [wire.CLOSE_KICKED]: "kicked",
  [wire.CLOSE_REPLACED]: "replaced",
  [wire.CLOSE_ROOM_OVER]: "over",
  [wire.CLOSE_BAD_MESSAGE]: "outdated",
  [wire.CLOSE_UNAUTHORISED]: "unauthorised",
  [wire.CLOSE_NOT_FOUND]: "notFound",
});

const MOVING_MS = 1000; // a room that moves is back within seconds

export class Connection {
  /** @type {WebSocket | null} */
  #socket = null;
  #tries = 0;
  #failed = 0;
  #answers = 0;
  #heard = new Elapsed();
  /** @type {wire.Bye | null} */
  #goodbye = null;
  #over = false;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #retry;
  /** @type {ReturnType<typeof setTimeout> | undefined} of the next ping, or until a handshake is given up */
  #ping;

  /** @param {string} room @param {wire.Mode} mode @param {Listener} listener */
  constructor(room, mode, listener) {
    this.room = room;
    this.mode = mode;
    this.listener = listener;
    addEventListener("online", () => this.#again(0));
    if (mode !== "play") return;
    takeLeftTokens(room);
    addEventListener("pagehide", () => leaveTokens(room));
  }

  open() {
    clearTimeout(this.#retry);
    clearTimeout(this.#ping);
    this.#socket?.close(); // perhaps still connecting, before the network changed
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/ws/${this.room}`, wire.SUBPROTOCOL);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#goodbye = null;
    this.#heard.restart();
    socket.onopen = () => socket === this.#socket && this.#join();
    socket.onmessage = (event) => socket === this.#socket && this.#hear(event.data);
    socket.onclose = (event) => socket === this.#socket && this.#closed(event);
    this.#ping = setTimeout(() => this.#giveUp(), HANDSHAKE_MS);
  }

  /** @param {wire.ClientMessage} message @returns {boolean} whether it could be sent */
  send(message) {
    return this.#put(JSON.stringify(message));
  }

  /** @param {wire.Input} input */
  sendInput(input) {
    return this.#put(wire.encodeInput(input));
  }

  /** Closes the connection for good. */
  close() {
    this.#end();
    this.#socket?.close();
  }

  /** @param {string | ArrayBuffer} frame */
  #put(frame) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(frame);
    return true;
  }

  #join() {
    this.#failed = 0;
    this.#answers = 0;
    const tokens = this.mode === "play" ? loadTokens(this.room) : [];
    const claim = this.mode === "play" && tokens.length === 0 ? 1 : 0;
    this.send({ type: "join", room: this.room, mode: this.mode, tokens, claim });
    this.#pingSoon(0);
  }

  /** @param {number} count pings so far on this socket */
  #pingSoon(count) {
    clearTimeout(this.#ping);
    this.#ping = setTimeout(
      () => {
        if (this.#heard.ms > SILENT_MS) {
          this.#lost();
          return;
        }
        this.#put(wire.encodePing({ clientMs: performance.now() }));
        this.#pingSoon(count + 1);
      },
      count < FIRST_PINGS ? FIRST_PING_MS : PING_MS,
    );
  }

  /** @param {string | ArrayBuffer} data */
  #hear(data) {
    const atMs = performance.now();
    this.#heard.restart();
    if (typeof data === "string") {
      this.#hearText(/** @type {wire.ServerMessage} */ (JSON.parse(data)), atMs);
      return;
    }
    const kind = new Uint8Array(data)[0];
    if (kind === wire.BUNDLE) this.listener.onBundle(wire.decodeBundle(data), atMs);
    if (kind === wire.PONG) {
      const { clientMs, serverMs } = wire.decodePong(data);
      this.listener.onPong(clientMs, serverMs, atMs);
    }
  }

  /** @param {wire.ServerMessage} message @param {number} atMs */
  #hearText(message, atMs) {
    if (message.type === "bye") this.#goodbye = message;
    if (message.type === "welcome") {
      if (message.protocol !== wire.PROTOCOL) {
        this.#end("outdated");
        this.#socket?.close();
        return;
      }
      if (this.mode === "play")
        saveTokens(
          this.room,
          message.seats.map((grant) => grant.token),
        );
      this.#tries = 0;
      this.listener.onStatus("open");
    }
    this.listener.onMessage(message, atMs);
  }

  /** @param {CloseEvent} event */
  #closed(event) {
    if (this.#over) return;
    clearTimeout(this.#ping);
    if (event.code === wire.CLOSE_UNAUTHORISED && this.mode === "play" && loadTokens(this.room).length > 0) {
      saveTokens(this.room, []); // an old key: perhaps the seat is open again
      this.#again(0);
      return;
    }
    if (event.code in ENDINGS) {
      this.#end(ENDINGS[event.code], this.#goodbye);
      return;
    }
    if (event.code === wire.CLOSE_RETRY) {
      this.#again(0); // the room is in another process of the server, which expects this page now
      return;
    }
    this.#retryLater();
  }

  /** A handshake that nobody answers, neither with yes nor with no. */
  #giveUp() {
    const socket = this.#socket;
    this.#socket = null;
    socket?.close();
    this.#retryLater();
  }

  #retryLater() {
    this.#failed += 1;
    if (this.#failed >= FAILED_TRIES) void this.#askWhy();
    const last = this.#goodbye?.error === "moving" ? MOVING_MS : BACK_OFF_MS.last;
    const waitMs = Math.min(last, BACK_OFF_MS.first * 2 ** this.#tries);
    this.#tries += 1;
    this.listener.onStatus("reconnecting", undefined, lossText(this.#goodbye) || this.#refusalText);
    this.#again(waitMs * (0.8 + 0.4 * Math.random())); // not everybody in the same instant
  }

  /** A dead connection: gives this socket up without waiting for its close. */
  #lost() {
    const socket = this.#socket;
    this.#socket = null;
    socket?.close();
    this.listener.onStatus("reconnecting");
    this.#again(0);
  }

  /** @param {number} waitMs */
  #again(waitMs) {
    if (this.#over || this.#socket?.readyState === WebSocket.OPEN) return;
    clearTimeout(this.#retry);
    this.#retry = setTimeout(() => this.open(), waitMs);
  }

  /** The handshake fails: is the room gone, the server away, this page too old, or is there no live connection now? */
  async #askWhy() {
    try {
      const { subprotocol = wire.SUBPROTOCOL } = await requestJson(`/api/rooms/${encodeURIComponent(this.room)}`);
      this.#answers += 1; // once means little: the server may have come back between the handshake and this question
      const outdated = subprotocol !== wire.SUBPROTOCOL;
      if (outdated && this.#answers >= ANSWERS && !this.#over) this.#end("outdated");
    } catch (error) {
      const status = /** @type {{status?: number}} */ (error).status;
      if (status === 404) this.#end("notFound");
      else this.#answers = 0; // nobody answers at all: keep trying
    }
  }

  /** Browsers do not tell their pages why a handshake is refused; empty while the server may just be away. */
  get #refusalText() {
    return this.#answers >= ANSWERS ? say("play.noLiveConnection") : "";
  }

  /** @param {string} [kind] a value of ENDINGS; none: this page hangs up @param {wire.Bye | null} [goodbye] */
  #end(kind, goodbye = null) {
    this.#over = true;
    clearTimeout(this.#retry);
    clearTimeout(this.#ping);
    this.listener.onStatus("over", kind ? { kind, sentence: endingText(kind, goodbye) } : undefined);
  }
}

/**
 * The reason that the server gave, where the catalogue knows it; else what the close code means.
 * @param {string} kind
 * @param {wire.Bye | null} goodbye
 */
function endingText(kind, goodbye) {
  const key = `error.${goodbye?.error}`;
  return goodbye && has(key) ? say(key, goodbye.values) : say(`play.closed.${kind}`);
}

/**
 * What the server said before it closed a connection that is tried again; empty where that helps nobody.
 * @param {wire.Bye | null} bye
 */
function lossText(bye) {
  const key = `error.${bye?.error}`;
  // "bad_request" is here a join that came late, and asks for a reload, which makes nothing quicker.
  return bye && bye.error !== "bad_request" && has(key) ? say(key, bye.values) : "";
}
