// @ts-check
/*
 * The admin token of this tab: asked for once, kept in sessionStorage as `movingout.admin`, sent as a header only.
 */

import { ApiError, requestJson } from "../core/api.js";
import { el, notice } from "../core/dom.js";
import { say, sayError } from "../text/catalogue.js";

const KEY = "movingout.admin";
const NOT_THERE = 404; // no token would help

/** The token that was given in this tab; empty when none was. */
export function kept() {
  try {
    return sessionStorage.getItem(KEY) ?? "";
  } catch {
    return "";
  }
}

/** @param {string} token */
function keep(token) {
  try {
    sessionStorage.setItem(KEY, token);
  } catch {
    // asked again after a reload
  }
}

/**
 * What `path` answers to an admin, and the token that opened it; asks for the token until it is right.
 * @param {HTMLElement} container where to ask; until then it says that the page loads, afterwards it is empty
 * @param {string} path
 * @param {string} [title] of a page that shows none yet
 * @returns {Promise<{token: string, document: any}>} ApiError when there is nothing at `path`
 */
export async function openWithToken(container, path, title = "") {
  let problem = "";
  for (let token = kept(); ; token = await ask(container, problem, title)) {
    if (!token) continue;
    try {
      const document = await requestJson(path, { token });
      keep(token);
      container.replaceChildren();
      return { token, document };
    } catch (error) {
      if (!(error instanceof ApiError) || error.status === NOT_THERE) {
        container.replaceChildren(notice("bad", sayError(error)));
        throw error;
      }
      problem = error.code === "wrong_token" ? say("dashboard.token.wrong") : sayError(error);
    }
  }
}

/** @param {HTMLElement} container @param {string} problem @param {string} title @returns {Promise<string>} */
function ask(container, problem, title) {
  const input = el("input", {
    id: "token",
    class: "input",
    type: "password",
    autocomplete: "off",
    spellcheck: "false",
    required: true,
  });
  const form = el(
    "form",
    { class: "card card-roomy stack token-form" },
    problem ? el("div", { role: "alert" }, notice("bad", problem)) : null,
    el(
      "div",
      { class: "field" },
      el("label", { for: "token" }, say("dashboard.token")),
      input,
      el("p", { class: "field-help" }, say("dashboard.token.help")),
    ),
    el("button", { type: "submit", class: "button button-primary" }, say("dashboard.open")),
  );
  container.replaceChildren(...(title ? [el("h1", {}, title)] : []), form);
  input.focus();
  return new Promise((done) => {
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      container.append(el("p", { class: "muted", role: "status" }, say("dashboard.loading")));
      done(input.value.trim());
    });
  });
}
