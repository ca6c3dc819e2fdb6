// The texts and bars beside the arena. Writes only what changed; no access to socket or devices.

import { badge, byId, el } from "../core/dom.js";
import { fitWords } from "../core/fit_words.js";
import { clockText, secondsOf } from "../core/ticks.js";
import { buttonName, keyName, moveName } from "../input/mapping.js";
import { has, say } from "../text/catalogue.js";
import { colourName, mapTitle } from "../text/names.js";
import {
  connectionWords,
  playingWords,
  reasonText,
  roundText,
  seatName,
  taskSentence,
  waitingWords,
} from "./seat_phrases.js";

/** @typedef {import("./game.js").Game} Game */
/** @typedef {import("./game.js").Scene} Scene */
/** @typedef {import("../input/mapping.js").Mapping} Mapping */
/** @typedef {import("../input/seats.js").SeatCard} SeatCard */
/** @typedef {import("../wire/connection.js").Status} Status */

const URGENT = ["help", "helpPartner", "gone", "away", "readyAway"]; // states of a partner that are worth a look
const PROBLEM_MS = 6000;

export class Hud {
  #parts = {
    play: byId("play", HTMLElement),
    round: byId("round", HTMLElement),
    title: byId("title", HTMLElement),
    task: byId("task", HTMLElement),
    score: byId("score", HTMLElement),
    timeLabel: byId("time-label", HTMLElement),
    time: byId("time", HTMLElement),
    timeBar: byId("time-bar", HTMLElement),
    doneLabel: byId("done-label", HTMLElement),
    done: byId("done", HTMLElement),
    doneBar: byId("done-bar", HTMLElement),
    seats: byId("seats", HTMLElement),
    connectionLabel: byId("connection-label", HTMLElement),
    connection: byId("connection", HTMLElement),
    watchers: byId("watchers", HTMLElement),
    recording: byId("recording", HTMLElement),
    problem: byId("problem", HTMLElement),
    controls: byId("controls", HTMLElement),
    get arena() {
      return byId("arena", HTMLCanvasElement); // it may have been replaced by one that draws faster
    },
    stalled: /** @type {Element} */ (document.querySelector("#stalled")),
    stop: byId("stop", HTMLButtonElement),
    stopWords: byId("stop-words", HTMLElement),
  };
  /** @type {Map<Element, string>} what was last written where */
  #written = new Map();
  #fitScore = fitWords(this.#parts.score, [this.#parts.timeLabel, this.#parts.doneLabel]);
  #seatRows = [0, 1].map((seat) => seatRow(seat));
  #fitConnection = fitWords(/** @type {HTMLElement} */ (this.#parts.connection.parentElement), [
    this.#parts.connection,
  ]);
  #fitSeats = fitWords(this.#parts.seats, [this.#parts.seats, ...this.#seatRows.map(({ name }) => name)]);
  #problemUntilMs = 0;

  constructor() {
    const { seats, timeLabel, doneLabel, connectionLabel, recording, stalled } = this.#parts;
    seats.replaceChildren(...this.#seatRows.map((row) => row.box));
    timeLabel.textContent = say("play.timeLeft");
    doneLabel.textContent = say("play.delivered");
    connectionLabel.textContent = say("play.connection");
    recording.textContent = say("play.notRecording");
    stalled.setAttribute("aria-label", say("play.announce.stalled"));
  }

  /**
   * Shows for a while why something cannot be done or may fail.
   * @param {string} sentence @param {number} nowMs @param {"bad" | "attention"} [tone]
   */
  showProblem(sentence, nowMs, tone = "bad") {
    this.#text(this.#parts.problem, sentence);
    this.#attribute(this.#parts.problem, "class", `notice notice-${tone} small play-problem`);
    this.#parts.problem.hidden = false;
    this.#problemUntilMs = nowMs + PROBLEM_MS;
  }

  /**
   * @param {Game} game @param {Scene | null} scene @param {Status} status @param {number} nowMs
   */
  update(game, scene, status, nowMs) {
    const { phase, room, welcome } = game;
    if (phase === "countdown" && room?.reason && !welcome?.study)
      this.showProblem(reasonText(room), nowMs, "attention");
    if (nowMs > this.#problemUntilMs) this.#parts.problem.hidden = true;
    const { play, connection, stalled, stop, stopWords } = this.#parts;
    play.dataset.phase = game.phase;
    const line = connectionWords(status, scene?.stalled ?? false, game.clock.rttMs);
    if (this.#text(connection, line.words)) this.#fitConnection();
    this.#attribute(connection, "class", line.state ? `pill pill-${line.state}` : "pill");
    stalled.toggleAttribute("hidden", !(scene?.stalled || status === "reconnecting"));
    this.#text(stopWords, stopSentence(game));
    stop.hidden = game.phase.endsWith("_over") && game.welcome?.mode !== "watch";
    if (game.round === null || scene === null) return;
    this.#heading(game.round, game.own.length === 0);
    this.#meters(game.round, scene);
    this.#players(game, scene);
    this.#company(game);
  }

  /** @param {import("./game.js").Round} round @param {boolean} watching */
  #heading(round, watching) {
    this.#text(this.#parts.round, round.practice ? say("play.practice") : roundText(round));
    this.#text(this.#parts.title, mapTitle(round.map));
    this.#text(this.#parts.task, taskSentence(round.map, watching));
  }

  /** @param {import("./game.js").Round} round @param {Scene} scene */
  #meters(round, scene) {
    const { time, timeLabel, timeBar, done, doneBar, arena } = this.#parts;
    const limited = round.limit_ticks > 0;
    const ticks = limited ? round.limit_ticks - scene.tick : scene.tick;
    this.#text(timeLabel, limited ? say("play.timeLeft") : say("play.time"));
    this.#text(time, clockText(secondsOf(ticks)));
    timeBar.hidden = !limited;
    this.#width(timeBar, limited ? ticks / round.limit_ticks : 0);
    const items = round.map.items.length;
    const delivered = scene.view.delivered.filter(Boolean).length;
    if (this.#text(done, `${delivered} / ${items}`)) this.#fitScore();
    this.#width(doneBar, items > 0 ? delivered / items : 0);
    this.#attribute(
      arena,
      "aria-label",
      say("play.arenaState", { map: mapTitle(round.map), done: delivered, total: items }),
    );
  }

  /** @param {Game} game @param {Scene} scene */
  #players(game, scene) {
    const { room, round, own, phase } = game;
    if (room === null || round === null) return;
    const running = phase === "playing" || phase === "paused";
    let isNew = false;
    room.seats.forEach((seat, index) => {
      const mine = own.includes(index);
      const device = has(`play.device.${seat.device}`) ? say(`play.device.${seat.device}`) : "";
      const name = own.length > 1 && mine && !seat.name ? colourName(index) : seatName(seat, mine, own.length === 0);
      const words = running
        ? playingWords(seat, index, round.map, scene.view, own)
        : waitingWords(seat, room.phase, mine);
      const urgent = URGENT.some((state) => words === say(`play.state.${state}`));
      const row = this.#seatRows[index];
      isNew = this.#text(row.name, mine && device ? `${name} · ${device}` : name) || isNew;
      isNew = this.#text(row.words, words) || isNew;
      this.#attribute(row.words, "data-state", urgent ? "attention" : "");
      row.box.toggleAttribute("data-own", mine);
    });
    if (isNew) this.#fitSeats();
  }

  /** @param {Game} game */
  #company(game) {
    const { watchers, recording } = this.#parts;
    const count = game.room?.spectators ?? 0;
    const watching = game.welcome?.mode === "watch";
    watchers.hidden = !watching && count === 0;
    this.#text(watchers, watching ? say("play.watching") : say("play.watchers", { count }));
    recording.hidden = game.recording || game.phase !== "playing" || game.round?.practice === true;
  }

  /**
   * The controls card: what to press on the device in use, per seat of this page.
   * @param {readonly SeatCard[]} cards @param {Mapping} mapping
   * @param {{change(): void, swap: (() => void) | null, pings: boolean}} actions swap: null in a study, which says
   *   who plays which robot
   */
  showControls(cards, mapping, actions) {
    const { controls } = this.#parts;
    const state = JSON.stringify([cards, mapping, actions.pings]);
    if (this.#written.get(controls) === state) return;
    this.#written.set(controls, state);
    controls.hidden = cards.length === 0;
    const blocks = cards.map((card) => keyBlock(card, mapping, cards.length > 1, actions.pings));
    const buttons = [
      el("button", { type: "button", class: "button-link small", onclick: actions.change }, say("play.change")),
    ];
    if (cards.length > 1 && actions.swap) {
      buttons.push(
        el("button", { type: "button", class: "button-link small", onclick: actions.swap }, say("play.ready.swap")),
      );
    }
    controls.replaceChildren(
      el("h2", {}, say("play.controls")),
      ...blocks,
      el("div", { class: "row row-apart" }, ...buttons),
    );
  }

  /** @param {Element} part @param {string} text @returns {boolean} whether it is new there */
  #text(part, text) {
    if (this.#written.get(part) === text) return false;
    this.#written.set(part, text);
    part.textContent = text;
    return true;
  }

  /** @param {Element} part @param {string} name @param {string} value */
  #attribute(part, name, value) {
    if (part.getAttribute(name) !== value) part.setAttribute(name, value);
  }

  /** @param {HTMLElement} bar @param {number} share */
  #width(bar, share) {
    const width = `${(100 * Math.max(0, Math.min(1, share))).toFixed(1)}%`;
    const fill = /** @type {HTMLElement} */ (bar.firstElementChild);
    if (fill.style.width !== width) fill.style.width = width;
  }
}

/** What the button below the cards does now. @param {Game} game */
function stopSentence(game) {
  if (game.welcome?.mode === "watch") return say("play.stopWatching");
  return game.phase === "lobby" ? say("play.leave") : say("play.pauseOrStop");
}

/** @param {number} seat */
function seatRow(seat) {
  const name = el("span", { class: "seat-name" });
  const words = el("span", { class: "seat-words" });
  const colour = el("span", { class: "sr-only" }, `${colourName(seat)}: `); // the badge is for eyes
  return { box: el("div", { class: "seat" }, badge(seat), colour, name, words), name, words };
}

/** @param {SeatCard} card @param {Mapping} mapping @param {boolean} named @param {boolean} pings */
function keyBlock(card, mapping, named, pings) {
  const rows = [...keyRows(card, mapping), ...(pings ? [pingRow(card, mapping)] : [])].map(([keys, effect]) =>
    el("li", {}, ...keys.flatMap((key) => [el("kbd", { translate: "no" }, key), " "]), el("span", {}, effect)),
  );
  const title = named ? el("p", { class: "agent small" }, badge(card.seat), colourName(card.seat)) : null;
  return el("div", { class: "keys" }, title, el("ul", {}, ...rows));
}

/** @param {SeatCard} card @param {Mapping} mapping @returns {[string[], string][]} */
export function keyRows(card, mapping) {
  const [move, grab, backward] = ["move", "grab", "backward"].map((action) => say(`play.action.${action}`));
  if (card.device === "gamepad") {
    return [
      [[say("button.leftStick")], move],
      [[buttonName(mapping.buttons.grab)], grab],
      [[buttonName(mapping.buttons.backward)], backward],
    ];
  }
  if (card.device === "touch") {
    return [
      [[say("play.touch.move")], move],
      [[say("play.touch.grab")], grab],
      [[say("play.touch.backward")], backward],
    ];
  }
  const sets = card.keySets.map((set) => mapping.keys[set]);
  return [
    [sets.map(moveName), move],
    [sets.map((keys) => keyName(keys.grab)), grab],
    [backwardNames(sets), backward],
  ];
}

/** @param {SeatCard} card @param {Mapping} mapping @returns {[string[], string]} */
function pingRow({ device, keySets }, { buttons, keys }) {
  const effect = say("play.action.ping");
  if (device === "gamepad") return [[buttonName(buttons.ping)], effect];
  return [device === "touch" ? ["!"] : keySets.map((set) => keyName(keys[set].ping)), effect];
}

/** Either shift key is "Shift" when both do the same. @param {readonly import("../input/mapping.js").KeySet[]} sets */
function backwardNames(sets) {
  const codes = sets.map((keys) => keys.backward);
  const shifts = codes.length === 2 && codes.includes("ShiftLeft") && codes.includes("ShiftRight");
  return shifts ? [say("key.Shift")] : codes.map(keyName);
}

/** How to say "press this" for a seat. @param {SeatCard} card @param {Mapping} mapping */
export function grabName(card, mapping) {
  if (card.device === "gamepad") return buttonName(mapping.buttons.grab);
  if (card.device === "touch") return say("play.touch.grab");
  return card.keySets.map((set) => keyName(mapping.keys[set].grab)).join(say("play.or"));
}

/** The parts of the page that touch uses, labelled. */
export function touchControls() {
  const [grab, backward] = [byId("touch-grab", HTMLElement), byId("touch-backward", HTMLElement)];
  grab.textContent = say("play.touch.grab");
  backward.textContent = say("play.touch.backward");
  for (const button of [grab, backward]) fitWords(button);
  return { zone: byId("stick", HTMLElement), knob: byId("knob", HTMLElement), grab, backward };
}
