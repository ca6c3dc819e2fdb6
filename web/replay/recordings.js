// @ts-check
/*
 * The list of recordings for the experimenter: filters, replay, download.
 */

import { openWithToken } from "../components/admin_token.js";
import { requestBlob } from "../core/api.js";
import { decodeValues } from "../core/metric_values.js";
import { namedBadge } from "../components/named_badge.js";
import { byId, el, notice } from "../core/dom.js";
import { filterChoices, filterRecordings, mapOf, playerWords } from "./recordings_filter.js";
import { save } from "./source.js";
import { duration, percent } from "../play/result/result_words.js";
import { currentLanguage, has, say, sayError } from "../text/catalogue.js";
import { mapTitle } from "../text/names.js";
import { prepareTexts } from "../text/page.js";

/** @typedef {import("./recordings_filter.js").Row} Row */

const PAGE_ROWS = 100; // shown at first, and added by "Show more"
const TONES = /** @type {Record<string, string>} */ ({
  delivered: "ok",
  left: "attention",
  stopped: "attention",
  error: "bad",
  interrupted: "attention",
});
const FILTERS = /** @type {const} */ ([
  { key: "map", words: (/** @type {string} */ map) => titleOf(rows.find((row) => mapOf(row) === map)) },
  { key: "player", words: playerWords },
  { key: "outcome", words: outcomeWords },
]);

/** @type {Row[]} */
let rows = [];
let adminToken = "";
let shown = PAGE_ROWS;

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
function filterField({ key, words }, values) {
  const options = [
    el("option", { value: "" }, say(`recordings.all.${key}`)),
    ...values.map((value) => el("option", { value }, words(value))),
  ];
  return el(
    "div",
    { class: "field" },
    el("label", { for: `filter-${key}` }, say(`recordings.column.${key}`)),
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
  if (all === 0) return say("recordings.none");
  return found < all ? say("recordings.found", { found, all }) : say("recordings.count", { count: all });
}

/** @param {Row} row */
function workDone({ metrics = {} }) {
  const { tcr } = decodeValues(metrics);
  return typeof tcr === "number" ? percent(tcr) : "–";
}

/** @param {Row} row */
function tableRow(row) {
  if (row.map === undefined) return damagedRow(row);
  const outcome = row.outcome ?? "";
  return el(
    "tr",
    {},
    cell("played", { class: "nowrap" }, when(row.started)),
    cell("map", { class: "strong" }, titleOf(row)),
    cell("players", {}, players(row)),
    cell(
      "outcome",
      {},
      el("span", { class: `pill ${TONES[outcome] ? `pill-${TONES[outcome]}` : ""}` }, outcomeWords(outcome)),
      row.complete ? null : el("span", { class: "pill pill-attention" }, say("replay.cutOff")),
    ),
    cell("time", { class: "number nowrap" }, duration(row.ticks ?? 0)),
    cell("tcr", { class: "number nowrap" }, workDone(row)),
    el("td", { class: "actions" }, ...rowActions(row)),
  );
}

/** @param {Row} row */
function rowActions(row) {
  const which = { map: titleOf(row), when: when(row.started) };
  const replay = el(
    "a",
    {
      class: "button button-small",
      href: `/replay/${encodeURIComponent(row.id)}`,
      "aria-label": say("recordings.replayThis", which),
    },
    say("recordings.replay"),
  );
  const save = el(
    "button",
    {
      type: "button",
      class: "button button-small",
      onclick: () => void download(row.id),
      "aria-label": say("recordings.downloadThis", which),
    },
    say("recordings.download"),
  );
  return [replay, save];
}

/** @param {Partial<Row>} [row] */
function titleOf({ map = "", title = "" } = {}) {
  return mapTitle({ name: map, title: title || undefined }) || "–";
}

/** @param {string} outcome */
function outcomeWords(outcome) {
  return has(`recordings.outcome.${outcome}`) ? say(`recordings.outcome.${outcome}`) : outcome || "–";
}

/** Fetched, since a link cannot carry the token that a study's server requires. @param {string} id */
async function download(id) {
  try {
    save(await requestBlob(`/api/recordings/${encodeURIComponent(id)}/file`, { token: adminToken }), `${id}.mcap`);
  } catch (error) {
    byId("ask", HTMLElement).replaceChildren(notice("bad", sayError(error)));
  }
}

/** @param {Row} row */
function damagedRow({ id, damage }) {
  return el(
    "tr",
    {},
    cell("file", { class: "strong" }, id),
    el("td", { colspan: 6 }, el("span", { class: "pill pill-bad" }, say("recordings.unreadable")), ` ${damage ?? ""}`),
  );
}

/** @param {Row} row */
function players({ blue, red }) {
  const side = (/** @type {number} */ seat, /** @type {string | undefined} */ player) =>
    el("span", { class: "agent" }, namedBadge(seat), playerWords(player));
  return el(
    "span",
    { class: "players" },
    side(0, blue),
    el("span", { class: "muted" }, say("recordings.with")),
    side(1, red),
  );
}

/**
 * @param {string} column whose name is shown where the table is a list
 * @param {Record<string, unknown>} props
 * @param {...(Node | string | null)} children
 */
function cell(column, props, ...children) {
  return el("td", { "data-label": say(`recordings.column.${column}`), ...props }, ...children);
}

/** @param {string} started */
function when(started) {
  const date = new Date(started);
  return Number.isNaN(date.getTime())
    ? "–"
    : date.toLocaleString(currentLanguage(), { dateStyle: "medium", timeStyle: "short" });
}

byId("filters", HTMLFormElement).addEventListener("change", () => {
  shown = PAGE_ROWS;
  refresh();
});
byId("more", HTMLElement).addEventListener("click", () => {
  shown += PAGE_ROWS;
  refresh();
});
await prepareTexts();
void load();
