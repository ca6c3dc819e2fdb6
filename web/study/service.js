// @ts-check
/*
 * The study's HTTP API for one participant, and the types of its answers. No access to the page.
 */

import { requestJson } from "../core/api.js";
import { isolated } from "../text/catalogue.js";
import { pickLanguage } from "../text/language.js";

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {import("../questionnaire/pages.js").Item} Item */
/** @typedef {{id: string, token: string, seat: number, path: string}} RoomSeat */
/** @typedef {{minutes: number, amount: number, currency: string}} Earned */
/**
 * A step as the server sends it: `key` and `kind`, the other fields depending on the kind.
 * @typedef {object} Step
 * @property {string} key
 * @property {string} kind
 * @property {string} [version]
 * @property {string} [html]
 * @property {{id: string, text: string, required: boolean}[]} [boxes]
 * @property {string} [title]
 * @property {Item[]} [items]
 * @property {Record<string, import("../questionnaire/pages.js").Given>} [answers]
 * @property {string | null} [partner_letter]
 * @property {boolean} [gamepad_required]
 * @property {number} [rtt_ms] the longest round trip allowed
 * @property {GameMap | null} [map]
 * @property {boolean} [map_named] title and description are the study's own
 * @property {string} [description]
 * @property {number} [seat]
 * @property {number} [number]
 * @property {number} [of]
 * @property {number} [limit_s]
 * @property {boolean} [tutorial] of a practice: the tutorial
 * @property {boolean} [sounds] whether rounds may be heard
 * @property {RoomSeat | null} [room]
 * @property {"card" | "waiting" | "playing" | "over"} [state]
 * @property {number} [since_s]
 * @property {number} [wait_s]
 * @property {number} [people]
 * @property {"code" | "agent"} [otherwise]
 * @property {number} [seconds]
 * @property {boolean} [ask_to_keep]
 * @property {string | null} [code]
 * @property {boolean} [shared_code] others have the same code, because the study file fixes it
 * @property {boolean} [long_ago] they finished so long ago that somebody else may sit here now
 * @property {string} [outcome]
 * @property {boolean | null} [kept]
 * @property {string | null} [completion_url]
 * @property {boolean} [from_platform] a recruitment platform sent them
 * @property {Earned | null} [earned]
 */
/**
 * @typedef {object} View
 * @property {{title: string}} study
 * @property {string} language
 * @property {string[]} languages
 * @property {Step} step
 * @property {{done: number, total: number}} position
 * @property {boolean} can_stop
 */
/**
 * What is known before anybody is.
 * @typedef {{title: string, titles?: Record<string, string>, languages: string[], asks_code: boolean, group?: number,
 *   one_screen?: boolean, pays?: boolean}}
 *   Study
 */
/** @typedef {import("../questionnaire/answer_queue.js").Answer} Answer */

/**
 * The title in a language that the study has, else in its first.
 * @param {Pick<Study, "title" | "titles">} study @param {string} language
 */
export function titleOf({ title, titles = {} }, language) {
  return isolated(titles[pickLanguage(Object.keys(titles), [language])] ?? title);
}

/** @returns {Promise<Study>} */
export function askStudy() {
  return requestJson("/api/study");
}

/**
 * @param {Record<string, string>} parameters of the link, or the typed code
 * @param {string} language
 * @param {string} [beside] token of the first person at this screen
 * @param {readonly string[]} [known] tokens that this browser has from before: they show who comes back
 * @returns {Promise<{token: string, view: View, replaces?: number | null, was_here?: boolean}>} `replaces`: which of
 *   `known` was theirs; `was_here`: whether one of them ever was
 */
export function arrive(parameters, language, beside, known = []) {
  return requestJson("/api/study/arrive", { body: { parameters, language, known, ...(beside && { beside }) } });
}

/** One participant's place in the study. */
export class Place {
  /** @param {string} token */
  constructor(token) {
    this.token = token;
  }

  /** @param {string} [language] to be used from now on @returns {Promise<View>} */
  view(language) {
    return this.#view("/api/study/view" + (language ? `?lang=${encodeURIComponent(language)}` : ""));
  }

  /** @param {string} key @param {Record<string, unknown>} [given] @returns {Promise<View>} */
  next(key, given = {}) {
    return this.#view("/api/study/next", { key, ...given });
  }

  /** @returns {Promise<View>} */
  decline() {
    return this.#view("/api/study/decline", {});
  }

  /** @param {boolean} keep @returns {Promise<View>} */
  stop(keep) {
    return this.#view("/api/study/stop", { keep });
  }

  /** @param {string} key @param {Answer} answer @returns {Promise<void>} */
  async answer(key, { question, value, text, elapsed_ms, hidden_ms }) {
    await requestJson("/api/study/answer", {
      token: this.token,
      body: { key, item: question, value, text, elapsed_ms, hidden_ms: hidden_ms ?? 0 },
    });
  }

  /** @param {string} path @param {unknown} [body] @returns {Promise<View>} */
  async #view(path, body) {
    const answer = await requestJson(path, { token: this.token, body });
    return answer.view ?? answer;
  }
}
