// @ts-check
/*
 * The experimenter's screen: who is where in the study, live, and what can be done about it. Cells change in place, so
 * that the keyboard focus stays where it is. What the numbers are called is in words.js.
 */

import { openWithToken } from "../components/admin_token.js";
import { NO_PILL, pill, remark, showFacts } from "../components/dashboard.js";
import { ApiError, requestJson } from "../core/api.js";
import { namedBadge } from "../components/named_badge.js";
import { byId, el, notice } from "../core/dom.js";
import { Elapsed } from "../core/elapsed.js";
import { Alerts } from "./alerts.js";
import { actor, askForAction, downloadPayments, openNext } from "./dialogs.js";
import {
  atWords,
  codeWords,
  facts,
  GROUPS,
  isIn,
  linkPill,
  noteWords,
  pausePill,
  recordingPill,
  seatNames,
  sorted,
  summaryWords,
  tickPill,
  timeWords,
  whereWords,
} from "./words.js";
import { LiveStream } from "../core/live_stream.js";
import { merged } from "./study_state.js";
import { titleOf } from "../study/service.js";
import { currentLanguage, say, sayError } from "../text/catalogue.js";
import { mapTitle } from "../text/names.js";
import { prepareTexts } from "../text/page.js";

/** @typedef {import("./words.js").StudyState} StudyState */
/** @typedef {import("./words.js").ParticipantRow} ParticipantRow */
/**
 * @typedef {object} Shown
 * @property {HTMLTableRowElement} row
 * @property {Map<string, HTMLElement>} cells
 * @property {HTMLAnchorElement} watch
 * @property {HTMLButtonElement} goOn ends a pause of this unit
 * @property {ParticipantRow} data
 */

const PATH = "/api/experimenter/state";
const WRONG_TOKEN = [401, 403];
const STALE_MS = 3000; // news comes each second; after this long without any, the page asks
const COLUMNS = ["participant", "step", "plays", "since", "link", "ticks", "recording"];
const CLASSES = /** @type {Record<string, string>} */ ({ participant: "strong", since: "nowrap", step: "nowrap" });

class Dashboard {
  #content = byId("content", HTMLElement);
  #rows = byId("participants", HTMLElement);
  #filter = byId("filter", HTMLSelectElement);
  /** @type {Map<string, Shown>} by pid */
  #shown = new Map();
  #news = new Elapsed(); // since the newest state came
  #alerts = new Alerts(byId("alerts", HTMLElement));
  /** @type {StudyState | null} */
  #state = null;

  /** @param {string} token */
  constructor(token) {
    this.token = token;
    this.act = actor(token);
  }

  start() {
    this.#content.hidden = false;
    byId("actions", HTMLElement).hidden = false;
    byId("open-next", HTMLButtonElement).addEventListener("click", () => void openNext(this.token, this.act));
    byId("pause", HTMLButtonElement).addEventListener(
      "click",
      () => void this.#do(this.#state?.paused ? "resume" : "pause", {}),
    );
    byId("payments", HTMLButtonElement).addEventListener(
      "click",
      () => void downloadPayments(this.token, byId("payments-said", HTMLElement)),
    );
    byId("note-form", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#addNote();
    });
    this.#filter.append(...GROUPS.map((group) => el("option", { value: group }, say(`experimenter.group.${group}`))));
    this.#filter.addEventListener("change", () => this.#state && this.#showParticipants(this.#state));
    new LiveStream("/api/experimenter/live", this.token, { onNews: (news) => this.#hear(news) }).open();
    setInterval(() => this.#news.ms > STALE_MS && void this.#ask(), 1000);
  }

  async #ask() {
    if (document.hidden) return;
    try {
      this.show(await requestJson(PATH, { token: this.token, signal: AbortSignal.timeout?.(STALE_MS) }));
    } catch (error) {
      // A restarted server has another token: the reloaded page asks for it.
      if (error instanceof ApiError && WRONG_TOKEN.includes(error.status)) location.reload();
      this.#setLost(error instanceof ApiError ? sayError(error) : say("dashboard.slowServer"));
    }
  }

  /** @param {string} action @param {Record<string, unknown>} body */
  async #do(action, body) {
    const problem = byId("problem", HTMLElement);
    problem.replaceChildren();
    try {
      await this.act(action, body);
      await this.#ask();
    } catch (error) {
      problem.replaceChildren(notice("bad", sayError(error)));
    }
  }

  async #addNote() {
    const area = byId("note", HTMLTextAreaElement);
    const said = byId("note-said", HTMLElement);
    if (!area.value.trim()) return area.focus();
    try {
      await this.act("note", { text: area.value.trim() });
      area.value = "";
      said.textContent = say("experimenter.note.kept");
      await this.#ask();
    } catch (error) {
      said.textContent = sayError(error);
    }
  }

  /** The last figures stay, but faded. @param {string} reason empty: all is well */
  #setLost(reason) {
    const box = byId("lost", HTMLElement);
    for (const part of this.#content.querySelectorAll(".facts-row, .table-card"))
      part.classList.toggle("stale", reason !== "");
    if (box.textContent === "" && reason === "") return;
    box.replaceChildren(...(reason ? [notice("bad", reason, ` ${say("dashboard.lastFigures")}`)] : []));
  }

  // ---- what is shown ----------------------------------------------------------------------------------------

  /** The whole state, what has changed of it, or more rows. @param {StudyState & {more?: ParticipantRow[]}} news */
  #hear(news) {
    this.show(/** @type {StudyState} */ (merged(this.#state, news)));
  }

  /** @param {StudyState} state */
  show(state) {
    this.#state = state;
    this.#news.restart();
    this.#setLost("");
    const title = titleOf(state.study, currentLanguage());
    byId("title", HTMLElement).textContent = title;
    document.title = say("experimenter.pageTitle", { study: title });
    byId("summary", HTMLElement).textContent = summaryWords(state);
    byId("pause", HTMLButtonElement).textContent = say(
      state.paused ? "experimenter.resumeAll" : "experimenter.pauseAll",
    );
    replaceText(byId("paused", HTMLElement), state.paused ? say("experimenter.allPaused") : "");
    showFacts(byId("facts", HTMLElement), facts(state));
    this.#alerts.show(state.alerts);
    this.#showParticipants(state);
    showNotes(state);
  }

  /** @param {StudyState} state */
  #showParticipants({ participants }) {
    const present = new Set(participants.map(({ pid }) => pid));
    for (const [pid, { row }] of this.#shown) {
      if (present.has(pid)) continue;
      row.remove();
      this.#shown.delete(pid);
    }
    sorted(participants).forEach((data, index) => {
      const shown = this.#shown.get(data.pid) ?? this.#add(data);
      if (shown.data !== data || shown.cells.get("participant")?.textContent === "") fill(shown, data);
      const after = this.#rows.children[index];
      if (after !== shown.row && !shown.row.contains(document.activeElement))
        this.#rows.insertBefore(shown.row, after ?? null);
    });
    this.#showGroup(participants);
  }

  /**
   * Hides whom the filter leaves out, and says when that is everybody.
   * @param {readonly ParticipantRow[]} participants
   */
  #showGroup(participants) {
    const group = GROUPS.find((one) => one === this.#filter.value) ?? "all";
    const seen = participants.filter((data) => isIn(data, group));
    for (const data of participants) {
      const row = this.#shown.get(data.pid)?.row;
      if (row) row.hidden = !seen.includes(data);
    }
    const empty = byId("empty", HTMLElement);
    empty.hidden = seen.length > 0;
    const text = say(participants.length > 0 ? "experimenter.emptyGroup" : "experimenter.empty");
    if (empty.textContent !== text) empty.textContent = text;
  }

  /** @param {ParticipantRow} data @returns {Shown} */
  #add(data) {
    const cells = new Map(
      COLUMNS.map((column) => [
        column,
        el("td", { "data-label": say(`dashboard.column.${column}`), class: CLASSES[column] ?? null }),
      ]),
    );
    const watch = el(
      "a",
      {
        class: "button button-small",
        target: "_blank",
        rel: "noopener",
        "aria-label": say("experimenter.watch", { pid: data.pid }),
      },
      say("dashboard.watch"),
    );
    const more = el(
      "button",
      { type: "button", class: "button button-small", "aria-label": say("experimenter.actionsFor", { pid: data.pid }) },
      say("dashboard.actions"),
    );
    const goOn = el(
      "button",
      {
        type: "button",
        class: "button button-small button-primary",
        "aria-label": say("experimenter.goOnFor", { pid: data.pid }),
        onclick: () => void this.#do("resume", { pid: data.pid }),
      },
      say("experimenter.goOn"),
    );
    const actions = el("td", { class: "actions" }, goOn, watch, more);
    const row = el("tr", { "data-pid": data.pid }, ...cells.values(), actions);
    const shown = { row, cells, watch, goOn, data };
    more.addEventListener("click", () =>
      askForAction(shown.data, async (action, body) => {
        await this.act(action, body);
        await this.#ask();
      }),
    );
    this.#rows.append(row);
    this.#shown.set(data.pid, shown);
    return shown;
  }
}

/** @param {Shown} shown @param {ParticipantRow} data */
function fill(shown, data) {
  shown.data = data;
  const { done, total } = data.position;
  const part = data.outcome ? "" : say("experimenter.part", { done: Math.min(done + 1, total), total });
  /** @type {Record<string, (Node | string)[]>} */
  const texts = {
    participant: [data.pid],
    step: [whereWords(data), ...remark(part), ...remark(codeWords(data)), ...pauseOf(data)],
    plays: seatsOf(data),
    since: [timeWords(data)],
    link: [pill(linkPill(data))],
    ticks: [pill(tickPill(data))],
    recording: [pill(recordingPill(data))],
  };
  for (const [column, parts] of Object.entries(texts)) {
    const cell = shown.cells.get(column);
    cell?.replaceChildren(...parts);
    cell?.toggleAttribute("data-empty", ["", "–"].includes(cell.textContent ?? ""));
  }
  shown.goOn.hidden = data.unit_paused !== true || data.outcome !== null;
  shown.watch.hidden = data.room === null;
  if (data.room !== null) shown.watch.href = `/watch/${encodeURIComponent(data.room)}`;
  shown.row.toggleAttribute("data-finished", data.outcome !== null);
}

/** @param {ParticipantRow} data */
function pauseOf(data) {
  const words = pausePill(data);
  return words === NO_PILL ? [] : [el("span", { class: "room-remark" }, pill(words))];
}

/** Both seats with who sits there, and the map. @param {ParticipantRow} data */
function seatsOf(data) {
  const names = seatNames(data);
  if (names === null) return [];
  const agents = names.map((name, seat) => el("span", { class: "agent" }, namedBadge(seat), name));
  return [
    el("span", { class: "room-seats" }, ...agents),
    ...remark(data.map ? mapTitle({ name: data.map, title: data.title }) : ""),
  ];
}

/** @param {StudyState} state */
function showNotes({ notes }) {
  const box = byId("notes", HTMLElement);
  const key = String(notes.length) + (notes[0]?.at ?? "");
  if (box.dataset.key === key) return;
  box.dataset.key = key;
  box.replaceChildren(
    ...notes.map(({ at, text, pid }) =>
      el(
        "li",
        {},
        el("span", { class: "muted small" }, [atWords(at), pid].filter(Boolean).join(" · ")),
        el("p", {}, noteWords(text)),
      ),
    ),
  );
}

/** @param {HTMLElement} box @param {string} text */
function replaceText(box, text) {
  if (box.textContent !== text) box.replaceChildren(...(text ? [notice("attention", text)] : []));
}

await prepareTexts();
const opened = await openWithToken(byId("ask", HTMLElement), PATH);
const dashboard = new Dashboard(opened.token);
dashboard.show(opened.document);
dashboard.start();
