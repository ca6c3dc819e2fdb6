// @ts-check
/*
 * The replay page: any finished recording in the game's own renderer. The episode is in data.js, the picture and the
 * time line in transport.js; this module joins them with what stands beside them.
 */

import { kept } from "../components/admin_token.js";
import { ApiError } from "../core/api.js";
import { byId, el, notice } from "../core/dom.js";
import { eventTone, eventWords, tickTime, shownEvents } from "./event_words.js";
import { offerGhosts } from "./ghost.js";
import { MetricCharts } from "./metric_curves.js";
import { ReplayError, episodeIn, linkedTick, tickAt } from "./data.js";
import { nextEventTick } from "./player.js";
import { Show } from "./show.js";
import { seatState, showSummary } from "./summary.js";
import { ReplaySource, save } from "./source.js";
import { Transport } from "./transport.js";
import { say, sayError } from "../text/catalogue.js";
import { prepareTexts } from "../text/page.js";
import { playingWords } from "../play/seat_phrases.js";

/** @typedef {import("./event_words.js").ShownEvent} ShownEvent */
/** @typedef {import("./data.js").Replay} Replay */

const ADDRESS_MS = 300; // after the last move: browsers limit how often the address may change

async function load() {
  const source = new ReplaySource(episodeIn(location.pathname));
  const ask = byId("ask", HTMLElement);
  try {
    const page = new ReplayPage(await source.load(ask), source);
    ask.hidden = true;
    byId("replay", HTMLElement).hidden = false;
    page.start();
  } catch (error) {
    if (!(error instanceof ApiError) && !(error instanceof ReplayError)) throw error;
    const again = el(
      "button",
      { type: "button", class: "button", onclick: () => location.reload() },
      say("replay.tryAgain"),
    );
    // for strangers, whom the list asks for a token
    const start = el("a", { class: "button button-primary", href: "/" }, say("play.over.lobby"));
    const list = el("a", { class: "button", href: "/recordings" }, say("replay.allRecordings"));
    ask.replaceChildren(
      notice("bad", error instanceof ReplayError ? error.message : sayError(error)),
      el("span", { class: "row replay-problem" }, start, again, list),
    );
  }
}

class ReplayPage {
  /** @param {Replay} replay @param {ReplaySource} source */
  constructor(replay, source) {
    this.replay = replay;
    this.source = source;
    this.transport = new Transport(
      (context, view, tick) => this.drawBeside(context, view, tick),
      () => this.scheduleAddress(),
    );
    this.transport.open(replay);
    this.player = this.transport.player;
    this.events = shownEvents(replay.summary.events, replay.ticks);
    /** @type {Map<ShownEvent, HTMLElement>} */
    this.rows = new Map();
    /** @type {ShownEvent | undefined} */
    this.current = undefined;
    this.charts = new MetricCharts(byId("curves", HTMLElement), replay.summary, (tick) =>
      this.transport.seekTick(tick),
    );
    this.show = new Show(
      replay,
      () => source.decisions(),
      () => this.transport.refresh(),
    );
    this.addressTimer = 0;
  }

  start() {
    if (kept())
      byId("list", HTMLAnchorElement).replaceWith(el("a", { href: "/recordings" }, say("dashboard.recordings")));
    this.showFacts();
    this.offerFile();
    this.showEvents();
    this.listen();
    this.seekLinked();
    Object.assign(window, {
      __movingout: {
        phase: "replay",
        player: this.player,
        replay: this.replay,
        entities: () => this.replay.viewAt(this.player.timeMs),
      },
    });
  }

  showFacts() {
    this.seatWords = showSummary(this.replay.summary);
  }

  /** A plain link where possible; a recording that needs a token is fetched and saved. */
  offerFile() {
    const link = byId("download", HTMLAnchorElement);
    const { id, path, open } = this.source;
    link.href = `${path}/file`;
    byId("ghost", HTMLElement).hidden = !open;
    if (open) return offerGhosts(byId("ghosts", HTMLElement), id, this.replay.summary.limit_ticks);
    link.addEventListener("click", (event) => {
      event.preventDefault();
      const tell = (/** @type {string} */ words) => (byId("said", HTMLElement).textContent = words);
      void this.source.file().then(
        (content) => save(content, `${id}.mcap`),
        (error) => tell(sayError(error)),
      );
    });
  }

  showEvents() {
    const { map, ticks } = this.replay.summary;
    for (const event of this.events) {
      const mark = el("span", { class: "replay-mark", "data-tone": eventTone(event) });
      mark.style.left = `${(100 * event.tick) / Math.max(ticks, 1)}%`;
      byId("marks", HTMLElement).append(mark);
      const row = el(
        "button",
        { type: "button", class: "replay-event", onclick: () => this.transport.seekTick(event.tick) },
        el("span", { class: "replay-mark", "data-tone": eventTone(event), "aria-hidden": "true" }),
        el("span", { class: "replay-event-time" }, tickTime(event.tick)),
        el("span", {}, eventWords(event, map)),
      );
      this.rows.set(event, row);
      byId("events", HTMLElement).append(el("li", {}, row));
    }
    if (this.events.length === 0)
      byId("events", HTMLElement).append(el("li", { class: "muted small" }, say("replay.noEvents")));
  }

  listen() {
    byId("copy", HTMLElement).addEventListener("click", () => void this.copyLink());
    this.transport.listen({
      ",": () => this.jump(-1),
      ".": () => this.jump(1),
      t: () => this.show.toggle("trails"),
      a: () => this.show.toggle("decisions"),
    });
    window.addEventListener("hashchange", () => this.seekLinked());
  }

  seekLinked() {
    this.transport.seekTick(linkedTick(location.hash, this.replay.ticks) ?? 0);
  }

  /** @param {-1 | 1} direction */
  jump(direction) {
    this.player.playing = false;
    this.transport.seekTick(nextEventTick(this.events, this.transport.tick, direction, this.replay.ticks));
  }

  async copyLink() {
    this.player.playing = false;
    this.transport.refresh();
    this.keepAddress();
    const done = await navigator.clipboard?.writeText(location.href).then(
      () => true,
      () => false,
    );
    byId("said", HTMLElement).textContent = say(done ? "replay.copied" : "replay.notCopied");
  }

  /** The address names the moment at which the replay stands. */
  scheduleAddress() {
    window.clearTimeout(this.addressTimer);
    if (!this.player.playing) this.addressTimer = window.setTimeout(() => this.keepAddress(), ADDRESS_MS);
  }

  keepAddress() {
    history.replaceState(null, "", `#tick=${tickAt(this.player.timeMs)}`);
  }

  /**
   * What stands over the arena and beside it.
   * @param {CanvasRenderingContext2D} context
   * @param {import("../view/render.js").View} view
   * @param {number} tick
   */
  drawBeside(context, view, tick) {
    this.show.draw(context, this.player.timeMs);
    this.drawWords(view);
    this.charts.show(tick);
    this.markEvent(tick);
  }

  /** @param {import("../view/render.js").View} view */
  drawWords(view) {
    const { map, seats } = this.replay.summary;
    for (const [index, seat] of seats.entries()) {
      const words = this.seatWords?.[index];
      if (words) words.textContent = playingWords(seatState(seat), index, map, view, []);
    }
  }

  /** Marks the latest event and scrolls it into view. @param {number} tick */
  markEvent(tick) {
    const current = this.events.findLast((event) => event.tick <= tick);
    if (current === this.current) return;
    if (this.current) this.rows.get(this.current)?.removeAttribute("aria-current");
    this.current = current;
    const row = current && this.rows.get(current);
    row?.setAttribute("aria-current", "true");
    const list = byId("events", HTMLElement);
    if (row) list.scrollTop = row.offsetTop - list.offsetTop - list.clientHeight / 2;
  }
}

await prepareTexts();
void load();
