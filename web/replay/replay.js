// @ts-check
/*
 * The replay page: any finished recording in the game's own renderer. The episode is in data.js, the
 * position in player.js; this module joins them with the page.
 */

import { ApiError } from "../core/api.js";
import { byId, el, notice } from "../core/dom.js";
import { ticksOf } from "../core/ticks.js";
import { eventTone, eventWords, tickTime, shownEvents } from "./event_words.js";
import { offerGhosts } from "../play/ghost.js";
import { MetricCharts } from "./metric_curves.js";
import { context2d, drawScene, fitCanvas } from "../view/render.js";
import { TICK_MS } from "../messages.js";
import { ReplayError, linkedTick, tickAt } from "./data.js";
import { Player, SPEEDS, nextEventTick } from "./player.js";
import { Show } from "./show.js";
import { seatState, showSummary } from "./summary.js";
import { ReplaySource, save } from "./source.js";
import { say, sayError } from "../text/catalogue.js";
import { prepareTexts } from "../text/page.js";
import { playingWords } from "../play/seat_phrases.js";

/** @typedef {import("./event_words.js").ShownEvent} ShownEvent */
/** @typedef {import("./data.js").Replay} Replay */

const PLAY_ICON = "M6 3.5v13l11-6.5z";
const PAUSE_ICON = "M5 3.5h4v13H5zM11 3.5h4v13h-4z";
const SECOND = ticksOf(1);
const ADDRESS_MS = 300; // after the last move: browsers limit how often the address may change
const LONGEST_FRAME_MS = 250; // a tab that was hidden does not jump ahead

const canvas = byId("arena", HTMLCanvasElement);
const line = byId("line", HTMLInputElement);
const speedSelect = byId("speed", HTMLSelectElement);
const playButton = byId("play", HTMLButtonElement);

async function load() {
  const source = new ReplaySource(decodeURIComponent(location.pathname.split("/").at(-1) ?? ""));
  const ask = byId("ask", HTMLElement);
  try {
    const page = new ReplayPage(await source.load(ask), source);
    ask.hidden = byId("loading", HTMLElement).hidden = true;
    byId("replay", HTMLElement).hidden = false;
    page.start();
  } catch (error) {
    if (!(error instanceof ApiError) && !(error instanceof ReplayError)) throw error;
    ask.hidden = true;
    const again = el(
      "button",
      { type: "button", class: "button", onclick: () => location.reload() },
      say("replay.tryAgain"),
    );
    const list = el("a", { class: "button", href: "/recordings" }, say("replay.allRecordings"));
    byId("loading", HTMLElement).replaceChildren(
      notice("bad", error instanceof ReplayError ? error.message : sayError(error)),
      el("span", { class: "row replay-problem" }, again, list),
    );
  }
}

class ReplayPage {
  /** @param {Replay} replay @param {ReplaySource} source */
  constructor(replay, source) {
    this.replay = replay;
    this.source = source;
    this.player = new Player(replay.durationMs, TICK_MS);
    this.events = shownEvents(replay.summary.events);
    /** @type {Map<ShownEvent, HTMLElement>} */
    this.rows = new Map();
    /** @type {ShownEvent | undefined} */
    this.current = undefined;
    this.charts = new MetricCharts(byId("curves", HTMLElement), replay.summary, (tick) => this.seekTick(tick));
    this.show = new Show(
      replay,
      () => source.decisions(),
      () => this.refresh(),
    );
    this.frame = 0;
    this.lastMs = 0;
    this.addressTimer = 0;
  }

  start() {
    this.showFacts();
    this.offerFile();
    this.showEvents();
    this.listen();
    this.player.seek((linkedTick(location.hash, this.replay.ticks) ?? 0) * TICK_MS);
    this.refresh();
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
    speedSelect.replaceChildren(...SPEEDS.map((speed) => el("option", { value: speed }, `${speed}×`)));
    speedSelect.value = "1";
    line.max = String(this.replay.ticks);
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
        { type: "button", class: "replay-event", onclick: () => this.seekTick(event.tick) },
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
    playButton.addEventListener("click", () => this.toggle());
    byId("back", HTMLElement).addEventListener("click", () => this.step(-1));
    byId("forward", HTMLElement).addEventListener("click", () => this.step(1));
    byId("copy", HTMLElement).addEventListener("click", () => void this.copyLink());
    line.addEventListener("input", () => this.seekTick(line.valueAsNumber));
    speedSelect.addEventListener("change", () => (this.player.speed = Number(speedSelect.value)));
    document.addEventListener("keydown", (event) => this.press(event));
    new ResizeObserver(() => this.refresh()).observe(canvas);
    window.addEventListener("movingout-theme", () => this.refresh());
    window.addEventListener("hashchange", () => this.seekTick(linkedTick(location.hash, this.replay.ticks) ?? 0));
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLSelectElement) return;
    const onButton =
      event.target instanceof Element && event.target.closest("button, a, summary, input[type=checkbox]") !== null;
    const far = event.shiftKey ? SECOND : 1;
    /** @type {Record<string, () => void>} */
    const keys = {
      ArrowLeft: () => this.step(-far),
      ArrowRight: () => this.step(far),
      ",": () => this.jump(-1),
      ".": () => this.jump(1),
      "-": () => this.changeSpeed(-1),
      "+": () => this.changeSpeed(1),
      "=": () => this.changeSpeed(1),
      Home: () => this.seekTick(0),
      End: () => this.seekTick(this.replay.ticks),
      t: () => this.show.toggle("trails"),
      a: () => this.show.toggle("decisions"),
      ...(onButton ? {} : { " ": () => this.toggle() }),
    };
    const action = keys[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  toggle() {
    this.player.toggle();
    this.refresh();
  }

  /** @param {number} ticks */
  step(ticks) {
    this.player.step(ticks);
    this.refresh();
  }

  /** @param {number} tick */
  seekTick(tick) {
    this.player.seek(tick * TICK_MS);
    this.refresh();
  }

  /** @param {-1 | 1} direction */
  jump(direction) {
    this.player.playing = false;
    this.seekTick(nextEventTick(this.events, tickAt(this.player.timeMs), direction, this.replay.ticks));
  }

  /** @param {-1 | 1} direction */
  changeSpeed(direction) {
    this.player.changeSpeed(direction);
    speedSelect.value = String(this.player.speed);
  }

  async copyLink() {
    this.player.playing = false;
    this.refresh();
    this.keepAddress();
    const done = await navigator.clipboard?.writeText(location.href).then(
      () => true,
      () => false,
    );
    byId("said", HTMLElement).textContent = say(done ? "replay.copied" : "replay.notCopied");
  }

  /** Draws the current instant, and keeps drawing while playing. */
  refresh() {
    if (this.player.playing && this.frame === 0) {
      this.lastMs = performance.now();
      this.frame = requestAnimationFrame((now) => this.animate(now));
    }
    window.clearTimeout(this.addressTimer);
    if (!this.player.playing) this.addressTimer = window.setTimeout(() => this.keepAddress(), ADDRESS_MS);
    this.draw();
  }

  keepAddress() {
    history.replaceState(null, "", `#tick=${tickAt(this.player.timeMs)}`);
  }

  /** @param {number} now */
  animate(now) {
    this.frame = 0;
    this.player.advance(Math.min(now - this.lastMs, LONGEST_FRAME_MS));
    this.lastMs = now;
    if (this.player.playing) this.frame = requestAnimationFrame((next) => this.animate(next));
    else this.refresh();
    this.draw();
  }

  draw() {
    const { map } = this.replay.summary;
    const tick = tickAt(this.player.timeMs);
    const view = this.replay.viewAt(this.player.timeMs);
    fitCanvas(canvas);
    drawScene(context2d(canvas), map, view, { rounded: true });
    this.show.draw(context2d(canvas), this.player.timeMs);
    this.drawLine(tick);
    this.drawWords(view);
    this.charts.show(tick);
    this.markEvent(tick);
    playButton.setAttribute("aria-label", say(this.player.playing ? "replay.pause" : "replay.play"));
    document.getElementById("play-icon")?.setAttribute("d", this.player.playing ? PAUSE_ICON : PLAY_ICON);
  }

  /** @param {number} tick */
  drawLine(tick) {
    const { ticks } = this.replay;
    line.valueAsNumber = tick;
    line.setAttribute("aria-valuetext", say("replay.timeOf", { time: tickTime(tick), all: tickTime(ticks) }));
    line.style.setProperty("--done", `${(100 * tick) / Math.max(ticks, 1)}%`);
    byId("time", HTMLElement).textContent = tickTime(tick);
    byId("tick", HTMLElement).textContent = say("replay.tickOf", { tick, ticks });
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
