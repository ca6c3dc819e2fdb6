// @ts-check
/*
 * The list of recordings for the experimenter: filters, replay, download.
 */

import { openWithToken } from "../components/admin_token.js";
import { ApiError, request } from "../core/api.js";
import { badge, byId, el, notice } from "../core/dom.js";
import { filterChoices, filterRecordings, mapTitle, playerName } from "./recordings_filter.js";
import { save } from "./source.js";
import { duration, percent } from "../play/result_words.js";
import { prepareTexts } from "../text/page.js";

/** @typedef {import("./recordings_filter.js").Row} Row */

const AT_ONCE = 100; // rows; more on demand
const OUTCOMES = /** @type {Record<string, {words: string, tone: string}>} */ ({
  delivered: { words: "all delivered", tone: "ok" },
  time: { words: "time was up", tone: "" },
  left: { words: "a player left", tone: "attention" },
  stopped: { words: "stopped", tone: "attention" },
  error: { words: "fault", tone: "bad" },
  interrupted: { words: "interrupted", tone: "attention" },
});
const FILTERS = /** @type {const} */ ([
  { key: "map", label: "Map", any: "Every map", words: mapTitle },
  { key: "player", label: "Player", any: "Everybody", words: playerName },
  {
    key: "outcome",
    label: "Result",
    any: "Every result",
    words: (/** @type {string} */ value) => OUTCOMES[value]?.words ?? value,
  },
]);

/** @type {Row[]} */
let rows = [];
let adminToken = "";
let shown = AT_ONCE;

async function load() {
  const { token, document: answer } = await openWithToken(byId("ask", HTMLElement), "/api/recordings");
  adminToken = token;
  rows = answer.recordings;
  const choices = filterChoices(rows);
  byId("filters", HTMLFormElement).replaceChildren(
    ...FILTERS.map((filter) => filterField(filter, choices[filter.key])),
  );
  byId("content", HTMLElement).hidden = false;
  refresh();
}

/** @param {(typeof FILTERS)[number]} filter @param {string[]} values */
function filterField({ key, label, any, words }, values) {
  const options = [el("option", { value: "" }, any), ...values.map((value) => el("option", { value }, words(value)))];
  return el(
    "div",
    { class: "field" },
    el("label", { for: `filter-${key}` }, label),
    el("select", { id: `filter-${key}`, name: key, class: "select" }, ...options),
  );
}

function refresh() {
  const chosen = new FormData(byId("filters", HTMLFormElement));
  const value = (/** @type {string} */ key) => String(chosen.get(key) ?? "");
  const found = filterRecordings(rows, { map: value("map"), player: value("player"), outcome: value("outcome") });
  byId("count", HTMLElement).textContent = countWords(found.length, rows.length);
  byId("rows", HTMLElement).replaceChildren(...found.slice(0, shown).map(tableRow));
  byId("more", HTMLElement).hidden = found.length <= shown;
}

/** @param {number} found @param {number} all */
function countWords(found, all) {
  if (all === 0) return "Nothing is recorded yet. Play a game and come back.";
  if (found < all) return `${found} of ${all} recordings`;
  return all === 1 ? "1 recording" : `${all} recordings`;
}

/** @param {Row} row */
function tableRow(row) {
  if (row.map === undefined) return damagedRow(row);
  const path = encodeURIComponent(row.id);
  const outcome = OUTCOMES[row.outcome ?? ""] ?? { words: row.outcome ?? "–", tone: "" };
  return el(
    "tr",
    {},
    cell("Played", { class: "nowrap" }, when(row.started)),
    cell("Map", { class: "strong" }, mapTitle(row.map)),
    cell("Players", {}, players(row)),
    cell(
      "Result",
      {},
      el("span", { class: `pill ${outcome.tone && `pill-${outcome.tone}`}` }, outcome.words),
      row.complete ? null : el("span", { class: "pill pill-attention" }, "cut off"),
    ),
    cell("Time", { class: "number nowrap" }, duration(row.ticks ?? 0)),
    cell("Work done", { class: "number nowrap" }, row.metrics ? percent(row.metrics.tcr) : "–"),
    el(
      "td",
      { class: "actions" },
      el(
        "a",
        {
          class: "button button-small",
          href: `/replay/${path}`,
          "aria-label": `Replay ${mapTitle(row.map)}, ${when(row.started)}`,
        },
        "Replay",
      ),
      el(
        "button",
        {
          type: "button",
          class: "button button-small",
          onclick: () => void download(row.id),
          "aria-label": `Download ${mapTitle(row.map)}, ${when(row.started)}`,
        },
        "Download",
      ),
    ),
  );
}

/** A link could not carry the token that a study's server asks for. @param {string} id */
async function download(id) {
  try {
    save(
      await (await request(`/api/recordings/${encodeURIComponent(id)}/file`, { token: adminToken })).blob(),
      `${id}.mcap`,
    );
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    byId("ask", HTMLElement).replaceChildren(notice("bad", error.message));
  }
}

/** @param {Row} row */
function damagedRow({ id, damage }) {
  return el(
    "tr",
    {},
    cell("File", { class: "strong" }, id),
    el("td", { colspan: 6 }, el("span", { class: "pill pill-bad" }, "unreadable"), ` ${damage ?? ""}`),
  );
}

/** @param {Row} row */
function players({ blue, red }) {
  const side = (/** @type {number} */ seat, /** @type {string | undefined} */ player) =>
    el("span", { class: "agent" }, badge(seat), playerName(player));
  return el("span", { class: "players" }, side(0, blue), el("span", { class: "muted" }, "with"), side(1, red));
}

/**
 * @param {string} label shown where the table is a list
 * @param {Record<string, unknown>} props
 * @param {...(Node | string | null)} children
 */
function cell(label, props, ...children) {
  return el("td", { "data-label": label, ...props }, ...children);
}

/** @param {string} started */
function when(started) {
  const date = new Date(started);
  return Number.isNaN(date.getTime()) ? "–" : date.toLocaleString("en-GB", { dateStyle: "medium", timeStyle: "short" });
}

byId("filters", HTMLFormElement).addEventListener("change", () => {
  shown = AT_ONCE;
  refresh();
});
byId("more", HTMLElement).addEventListener("click", () => {
  shown += AT_ONCE;
  refresh();
});
await prepareTexts();
void load();
