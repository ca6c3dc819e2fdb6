// @ts-check
/*
 * Where the replay page gets an episode: the open API of a game server, or, on a server that runs a study, the same
 * with the admin token.
 */

import { openWithToken } from "../components/admin_token.js";
import { ApiError, contentOf, request, requestBlob, requestJson } from "../core/api.js";
import { decodeCurves, decodeValues } from "../core/metric_values.js";
import { say } from "../text/catalogue.js";
import { Replay } from "./data.js";

/** @typedef {import("./overlay.js").DecisionTrace} DecisionTrace */

const FORBIDDEN = 401;

export class ReplaySource {
  #token;

  /** @param {string} id episode id @param {string} [token] of the admin, where the page knows it already */
  constructor(id, token = "") {
    this.id = id;
    this.#token = token;
    this.path = `/api/recordings/${encodeURIComponent(id)}`;
  }

  /** Whether anybody may see recordings here, and play with them. */
  get open() {
    return this.#token === "";
  }

  /** Raises ApiError or ReplayError with a sentence. @param {HTMLElement} ask where to ask for the admin token */
  async load(ask) {
    const summary = await this.#summary(ask);
    // The server has computed and kept the poses with the summary.
    const poses = await contentOf(request(`${this.path}/poses`, { token: this.#token }), "arrayBuffer");
    const { metrics, curves } = summary;
    const decoded = { ...summary, metrics: decodeValues(metrics), curves: decodeCurves(curves) };
    return new Replay(decoded, poses);
  }

  /** @returns {Promise<DecisionTrace[]>} in order of ticks */
  async decisions() {
    return (await requestJson(`${this.path}/thoughts`, { token: this.#token })).thoughts;
  }

  /** The recording itself. */
  file() {
    return requestBlob(`${this.path}/file`, { token: this.#token });
  }

  /** @param {HTMLElement} ask */
  async #summary(ask) {
    try {
      return await requestJson(this.path, { token: this.#token });
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== FORBIDDEN) throw error;
    }
    const { token, document } = await openWithToken(ask, this.path, say("replay.title"));
    this.#token = token;
    return document;
  }
}

/** Saves a file that needed a token, as a link to it would. @param {Blob} content @param {string} name */
export function save(content, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  window.setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
