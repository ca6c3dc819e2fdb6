// @ts-check
/*
 * The HTTP API for pages: JSON in, JSON out, and every failure as an `ApiError` whose message can be shown.
 */

export const SERVER_GONE = "The game server does not answer. Check that it is running and that you are online.";

export class ApiError extends Error {
  /**
   * @param {string} code the server's error code, or "offline"
   * @param {string} message a sentence for people
   * @param {number} status HTTP status, 0 when nothing answered
   * @param {Readonly<Record<string, unknown>>} [values] what the sentence tells besides, by name
   */
  constructor(code, message, status, values = {}) {
    super(message);
    this.name = "ApiError";
    this.code = code;
    this.status = status;
    this.values = values;
  }
}

/**
 * @param {string} path
 * @param {{token?: string, body?: unknown, method?: string, signal?: AbortSignal, keepalive?: boolean}} [options]
 *   `keepalive`: it goes out although the page is being left
 * @returns {Promise<Response>} an answer with a 2xx status
 */
export async function request(path, { token, body, method, signal, keepalive = false } = {}) {
  const headers = new Headers();
  if (token) headers.set("Authorization", `Bearer ${token}`);
  if (body !== undefined) headers.set("Content-Type", "application/json");
  const init = { method: method ?? (body === undefined ? "GET" : "POST"), headers, signal: signal ?? null, keepalive };
  const answer = await fetch(path, body === undefined ? init : { ...init, body: JSON.stringify(body) }).catch(noAnswer);
  if (!answer.ok) throw await refusal(answer);
  return answer;
}

/**
 * @param {string} path
 * @param {{token?: string, body?: unknown, method?: string, signal?: AbortSignal, keepalive?: boolean}} [options]
 * @returns {Promise<any>}
 */
export function requestJson(path, options) {
  return contentOf(request(path, options), "json");
}

/** A file, whole. @param {string} path @param {{token?: string}} [options] @returns {Promise<Blob>} */
export function requestBlob(path, options) {
  return contentOf(request(path, options), "blob");
}

/**
 * What an answer contains, all of it. One that breaks off, or is no JSON, such as the page with which a public network
 * asks for a login, is an ApiError like no answer at all.
 * @template {"json" | "blob" | "arrayBuffer" | "text"} Kind
 * @param {Promise<Response>} answer @param {Kind} kind
 * @returns {Promise<Awaited<ReturnType<Response[Kind]>>>}
 */
export async function contentOf(answer, kind) {
  const content = /** @type {Promise<any>} */ ((await answer)[kind]());
  return content.catch(noAnswer);
}

/** @param {unknown} error with which a request failed @returns {never} */
function noAnswer(error) {
  if (error instanceof DOMException && error.name === "AbortError") throw error;
  throw new ApiError("offline", SERVER_GONE, 0);
}

/**
 * The server's own sentence, where it sent one.
 * @param {Response} answer
 */
async function refusal(answer) {
  const document = await answer.json().catch(() => null); // a proxy's page, say
  const error = document?.error;
  if (typeof error?.message === "string")
    return new ApiError(String(error.code), error.message, answer.status, error.values);
  return new ApiError(
    "http",
    `The server refused this (${answer.status}). Reload the page and try again.`,
    answer.status,
  );
}
