// @ts-check
/*
 * The annotator's page: one failure case after the other is watched and confirmed or rejected. Annotators see neither
 * the names of agents nor what others said.
 */

import { openWithToken } from "../components/admin_token.js";
import { ApiError, requestBlob, requestJson } from "../core/api.js";
import { namedBadge } from "../components/named_badge.js";
import { byId, el, notice } from "../core/dom.js";
import { ticksOf } from "../core/ticks.js";
import { ReplayError } from "../replay/data.js";
import { itemName, tickTime } from "../replay/event_words.js";
import { ReplaySource, save } from "../replay/source.js";
import { Transport } from "../replay/transport.js";
import { say, sayError } from "../text/catalogue.js";
import { colourName, mapTitle } from "../text/names.js";
import { prepareTexts } from "../text/page.js";
import { askName, forgetName, keptName } from "./annotator.js";
import { highlight } from "./highlight.js";
import { CASES, hasBoth, judged, mayJudge, neighbour, nextOpen, wantedFindings } from "./queue.js";

/** @typedef {import("./queue.js").Finding} Finding */
/** @typedef {import("./queue.js").Said} Said */
/** @typedef {import("./queue.js").Verdict} Verdict */

const API = "/api/findings";
const VERDICTS = /** @type {const} */ (["confirmed", "rejected", "unsure"]);
const TONES = { confirmed: "pill-bad", rejected: "pill-ok", unsure: "" };
const BEFORE = ticksOf(3); // shown before a finding, and after it
const ASK_AGAIN_MS = 500; // while the server still searches

const noteInput = byId("note", HTMLInputElement);

async function load() {
  const ask = byId("ask", HTMLElement);
  const loading = byId("loading", HTMLElement);
  try {
    const { token, document: first } = await openWithToken(ask, API, say("annotate.title"));
    const findings = await searched(first, token, loading);
    const annotator = keptName() || (await askName(ask));
    const { verdicts } = await requestJson(`${API}/verdicts?annotator=${encodeURIComponent(annotator)}`, { token });
    loading.hidden = true;
    if (findings.length === 0) return ask.replaceChildren(notice("", say("annotate.none")));
    ask.hidden = true;
    byId("annotate", HTMLElement).hidden = false;
    new AnnotatePage(findings, verdicts, annotator, token).start();
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    loading.hidden = true;
    ask.replaceChildren(notice("bad", sayError(error)));
  }
}

/**
 * Asks again until everything is searched.
 * @param {{findings: Finding[], searched: number, remaining: number}} answer
 * @param {string} token @param {HTMLElement} loading
 */
async function searched(answer, token, loading) {
  while (answer.remaining > 0) {
    const all = answer.searched + answer.remaining;
    loading.hidden = false;
    loading.textContent = say("annotate.searching", { done: answer.searched, all });
    await new Promise((done) => window.setTimeout(done, ASK_AGAIN_MS));
    answer = await requestJson(API, { token });
  }
  return answer.findings;
}

class AnnotatePage {
  /** @type {Finding | null} */
  #current = null;
  /** @type {import("../replay/data.js").Replay | null} */
  #replay = null;
  /** @type {import("./queue.js").Sight} */
  #sight = "loading";
  #stopsAt = Infinity; // ticks; where the excerpt ends, unless somebody moves on
  #visits = 0; // findings opened so far
  /** @type {Set<Finding>} whose verdicts are on their way */
  #saving = new Set();
  /** @type {Map<Finding, string>} notes of verdicts that could not be saved */
  #unsaved = new Map();

  /** @param {Finding[]} findings @param {Record<string, Said>} said @param {string} annotator @param {string} token */
  constructor(findings, said, annotator, token) {
    this.findings = findings;
    this.said = said;
    this.annotator = annotator;
    this.token = token;
    this.wanted = { kind: "", who: hasBoth(findings) ? "agents" : "" };
    this.transport = new Transport((context, view, tick) => this.#drawn(context, view, tick));
  }

  get shown() {
    return wantedFindings(this.findings, this.wanted);
  }

  start() {
    this.#showFilters();
    this.#listen();
    this.#showList();
    Object.assign(window, { __movingout: { phase: "annotate", transport: this.transport } });
    void this.open(nextOpen(this.shown, this.said, "") ?? this.shown[0] ?? null);
  }

  /** Shows a finding and plays it. @param {Finding | null} finding */
  async open(finding) {
    this.#current = finding;
    this.#visits += 1;
    this.#replay = null;
    this.#sight = "loading";
    byId("marks", HTMLElement).replaceChildren();
    this.#showList();
    this.#ask();
    if (finding === null) return;
    try {
      const replay = await new ReplaySource(finding.recording, this.token).load(byId("ask", HTMLElement));
      if (this.#current !== finding) return; // another one was chosen meanwhile
      this.#replay = replay;
      this.transport.open(replay);
      this.#sight = "shown";
      this.#markSpan(finding, replay.ticks);
      this.watch();
    } catch (error) {
      if (!(error instanceof ApiError) && !(error instanceof ReplayError)) throw error;
      if (this.#current !== finding) return;
      this.#sight = "unreadable";
      this.#press();
      this.#problem(error);
    }
  }

  /** Plays the excerpt around the finding; those who want less motion start it themselves. */
  watch() {
    const finding = this.#current;
    if (finding === null || this.#replay === null) return;
    this.#stopsAt = finding.end + BEFORE;
    this.transport.player.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.transport.seekTick(Math.max(finding.start - BEFORE, 0));
  }

  /** @param {Verdict} verdict */
  async judge(verdict) {
    const finding = this.#current;
    if (finding === null || this.#saving.has(finding) || !mayJudge(verdict, this.#sight)) return;
    const visit = this.#visits;
    this.#saving.add(finding);
    const said = { verdict, note: noteInput.value.trim() };
    try {
      const body = { finding: finding.id, annotator: this.annotator, ...said };
      await requestJson(`${API}/verdicts`, { token: this.token, body });
      this.said[finding.id] = said;
      this.#unsaved.delete(finding);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.#unsaved.set(finding, said.note);
      return this.#problem(error, visit === this.#visits ? null : finding);
    } finally {
      this.#saving.delete(finding);
    }
    if (visit !== this.#visits) return this.#showAnswer(); // another one was chosen meanwhile
    const next = nextOpen(this.shown, this.said, finding.id);
    if (next) void this.open(next);
    else this.#finished();
  }

  /** @param {-1 | 1} direction */
  move(direction) {
    const next = neighbour(this.shown, this.#current?.id ?? "", direction);
    if (next) void this.open(next);
  }

  #finished() {
    this.#showList();
    this.#ask();
    byId("problem", HTMLElement).replaceChildren(notice("ok", say("annotate.finished")));
  }

  #listen() {
    for (const verdict of VERDICTS) this.#listenTo(byId(verdict, HTMLElement), verdict);
    byId("again", HTMLElement).addEventListener("click", () => this.watch());
    byId("download", HTMLElement).addEventListener("click", () => void this.#download());
    const rename = byId("rename", HTMLElement);
    rename.textContent = say("annotate.rename", { name: this.annotator });
    rename.addEventListener("click", () => {
      forgetName();
      location.reload();
    });
    this.transport.listen({
      1: () => void this.judge("confirmed"),
      2: () => void this.judge("rejected"),
      3: () => void this.judge("unsure"),
      r: () => this.watch(),
      ",": () => this.move(-1),
      ".": () => this.move(1),
    });
  }

  /**
   * One press is one verdict: a double click, or a key held down, does not judge the next finding.
   * @param {HTMLElement} button @param {Verdict} verdict
   */
  #listenTo(button, verdict) {
    button.addEventListener("click", (event) => event.detail < 2 && void this.judge(verdict));
    button.addEventListener("keydown", (event) => event.repeat && event.preventDefault());
  }

  #showFilters() {
    const kinds = ["", ...CASES].map((kind) => el("option", { value: kind }, say(`annotate.case.${kind || "all"}`)));
    const players = ["agents", "people", ""].map((who) =>
      el("option", { value: who }, say(`annotate.who.${who || "all"}`)),
    );
    const choice = (/** @type {"kind" | "who"} */ key, /** @type {HTMLElement[]} */ options) => {
      const select = el("select", { class: "select", "aria-label": say(`annotate.filter.${key}`) }, ...options);
      select.value = this.wanted[key];
      select.addEventListener("change", () => {
        this.wanted[key] = select.value;
        void this.open(nextOpen(this.shown, this.said, "") ?? this.shown[0] ?? null);
      });
      return select;
    };
    byId("filters", HTMLElement).replaceChildren(
      choice("kind", kinds),
      ...(hasBoth(this.findings) ? [choice("who", players)] : []),
    );
  }

  #showList() {
    const { shown } = this;
    byId("progress", HTMLElement).textContent = say("annotate.progress", {
      done: judged(shown, this.said),
      all: shown.length,
    });
    byId("findings", HTMLElement).replaceChildren(...shown.map((finding) => el("li", {}, this.#row(finding))));
    const current = document.querySelector(".annotate-finding[aria-current]");
    const list = byId("findings", HTMLElement);
    if (current instanceof HTMLElement)
      list.scrollTop = current.offsetTop - list.offsetTop - list.clientHeight / 2 + current.offsetHeight / 2;
  }

  /** @param {Finding} finding */
  #row(finding) {
    const verdict = this.said[finding.id]?.verdict;
    return el(
      "button",
      {
        type: "button",
        class: "replay-event annotate-finding",
        "aria-current": finding === this.#current ? "true" : null,
        onclick: () => void this.open(finding),
      },
      namedBadge(finding.seat),
      el("span", {}, say(`annotate.case.${finding.case}`)),
      verdict ? el("span", { class: `pill ${TONES[verdict]}` }, say(`annotate.${verdict}`)) : null,
      el("span", { class: "small muted" }, this.#place(finding)),
    );
  }

  /** @param {Finding} finding */
  #place(finding) {
    return `${mapTitle({ name: finding.map })} · ${tickTime(finding.start)}`;
  }

  /** The question about the current finding, and what was answered before. */
  #ask() {
    const finding = this.#current;
    const said = finding ? this.said[finding.id] : undefined;
    noteInput.value = (finding && this.#unsaved.get(finding)) ?? said?.note ?? "";
    byId("problem", HTMLElement).replaceChildren();
    byId("question", HTMLElement).textContent = finding ? this.#question(finding) : say("annotate.noneWanted");
    this.#press();
  }

  /** An answer that was saved while something else was done. */
  #showAnswer() {
    this.#showList();
    this.#press();
  }

  /** Shows the answer on the buttons. */
  #press() {
    const said = this.#current ? this.said[this.#current.id] : undefined;
    for (const verdict of VERDICTS) {
      const button = byId(verdict, HTMLButtonElement);
      button.disabled = this.#current === null || (this.#sight === "unreadable" && !mayJudge(verdict, this.#sight));
      button.setAttribute("aria-pressed", String(said?.verdict === verdict));
    }
  }

  /** @param {Finding} finding */
  #question({ case: kind, seat, item }) {
    const what = this.#replay ? itemName(this.#replay.summary.map.items[item]) : say("annotate.theItem");
    const values = { who: colourName(seat), other: colourName(1 - seat), what };
    return say(`annotate.question.${kind}`, values);
  }

  /** Where the finding lies on the time line. @param {Finding} finding @param {number} ticks */
  #markSpan({ start, end }, ticks) {
    const span = el("span", { class: "annotate-span" });
    const percent = (/** @type {number} */ tick) => (100 * tick) / Math.max(ticks, 1);
    span.style.left = `${percent(start)}%`;
    span.style.width = `${percent(Math.min(end, ticks) - start)}%`;
    byId("marks", HTMLElement).replaceChildren(span);
    if (this.#current) byId("question", HTMLElement).textContent = this.#question(this.#current);
  }

  /** @param {CanvasRenderingContext2D} context @param {import("../view/render.js").View} view @param {number} tick */
  #drawn(context, view, tick) {
    const finding = this.#current;
    if (finding === null || this.#replay === null) return;
    if (tick >= finding.start && tick <= finding.end) highlight(context, this.#replay.summary.map, view, finding);
    if (tick < this.#stopsAt) return;
    this.transport.player.playing = false;
    this.#stopsAt = Infinity; // whoever plays on, or has moved on in a pause, sees the rest
  }

  async #download() {
    try {
      save(await requestBlob(`${API}/annotations.csv`, { token: this.token }), "annotations.csv");
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.#problem(error);
    }
  }

  /** @param {ApiError | ReplayError} error @param {Finding | null} left that it is about, where another one is open */
  #problem(error, left = null) {
    const words = error instanceof ApiError ? sayError(error) : error.message;
    const about = left ? `${say("annotate.notSaved", { what: this.#place(left) })} ` : "";
    byId("problem", HTMLElement).replaceChildren(notice("bad", about + words));
  }
}

await prepareTexts();
void load();
