// @ts-check
/*
 * News from the server as it happens: server-sent events read with fetch, because an EventSource cannot send the token
 * as a header. Reconnects after a loss; a silent connection is given up.
 */

const SILENT_MS = 15_000; // the server says at least a comment line every 5 s
const BACK_OFF_MS = [500, 1000, 2000, 4000, 8000];

/** @typedef {{onNews: (news: any) => void, onState?: (open: boolean) => void}} Listener */

export class LiveStream {
  #tries = 0;
  #closed = false;
  /** @type {AbortController | null} */
  #abort = null;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /** @param {string} path @param {string} token @param {Listener} listener */
  constructor(path, token, listener) {
    this.path = path;
    this.token = token;
    this.listener = listener;
  }

  /** @returns {this} */
  open() {
    void this.#run();
    return this;
  }

  close() {
    this.#closed = true;
    clearTimeout(this.#timer);
    this.#abort?.abort();
  }

  async #run() {
    const abort = new AbortController();
    this.#abort = abort;
    try {
      const headers = { Authorization: `Bearer ${this.token}`, Accept: "text/event-stream" };
      const answer = await fetch(this.path, { headers, signal: abort.signal, cache: "no-store" });
      if (answer.ok && answer.body) await this.#read(answer.body, abort);
      else if (answer.status === 401 || answer.status === 403) this.#closed = true; // polling says why
    } catch {
      // lost or given up: reconnects below
    }
    abort.abort();
    if (this.#closed) return;
    this.listener.onState?.(false);
    this.#timer = setTimeout(() => void this.#run(), BACK_OFF_MS[Math.min(this.#tries, BACK_OFF_MS.length - 1)]);
    this.#tries += 1;
  }

  /** @param {ReadableStream<Uint8Array>} body @param {AbortController} abort */
  async #read(body, abort) {
    const decoder = /** @type {ReadableWritablePair<string, Uint8Array<ArrayBuffer>>} */ (new TextDecoderStream());
    const reader = /** @type {ReadableStream<Uint8Array<ArrayBuffer>>} */ (body).pipeThrough(decoder).getReader();
    const lines = new EventLines();
    for (;;) {
      const watchdog = setTimeout(() => abort.abort(), SILENT_MS);
      const { done, value } = await reader.read().finally(() => clearTimeout(watchdog));
      if (done || this.#closed) return;
      this.#tries = 0;
      this.listener.onState?.(true);
      for (const data of lines.push(value)) this.listener.onNews(JSON.parse(data));
    }
  }
}

/** Splits a text/event-stream into the data of its events. */
export class EventLines {
  #rest = "";
  /** @type {string[]} */
  #data = [];

  /** @param {string} text as it arrives, in pieces of any size @returns {string[]} the events that are complete */
  push(text) {
    const lines = (this.#rest + text).split(/\r\n|\n/);
    this.#rest = lines.pop() ?? "";
    /** @type {string[]} */
    const events = [];
    for (const line of lines) {
      if (line.startsWith("data:")) this.#data.push(line.slice(5).trimStart());
      else if (line === "" && this.#data.length > 0) events.push(this.#data.splice(0).join("\n"));
    }
    return events;
  }
}
