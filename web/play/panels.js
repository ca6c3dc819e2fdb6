// The panels before, between and after rounds: the ready card beside the arena, and over the arena the countdown, the
// pause and the end. Rebuilt only when their content changes. No access to the socket: clicks go to `actions`.

import { badge, byId, el } from "../core/dom.js";
import { moveName } from "../input/mapping.js";
import { grabName } from "./hud.js";
import { invitation } from "./invitation.js";
import { say } from "../text/catalogue.js";
import { colourName, colourWord, mapDescription } from "../text/names.js";
import { heldText, isOver, pauseLimitText, reasonText, waitingForText } from "./seat_phrases.js";

/** @typedef {import("./game.js").Game} Game */
/** @typedef {import("../input/seats.js").SeatCard} SeatCard */
/** @typedef {import("../input/mapping.js").Mapping} Mapping */
/**
 * @typedef {object} Actions
 * @property {(seat: number) => void} ready
 * @property {() => void} stop  for good
 * @property {(() => void) | null} askStop  asks in its own way whether to stop; null: asked here
 * @property {boolean} asksReady  false in a study, whose map card has asked already
 */

/**
 * @typedef {object} News
 * @property {boolean} busy  another view asks for attention
 * @property {string} lost  what is wrong with the connection
 * @property {boolean} deaf  the grab key does not count yet
 * @property {string} hint  what else a pause is to say
 */

const ACTION = ".button-primary, [data-safe]"; // the button that goes on, or one that changes nothing

export class Panels {
  #ready = byId("ready", HTMLElement);
  #overlay = byId("overlay", HTMLElement);
  #readyKey = "";
  #overlayKey = "page"; // what the page itself says until its program has begun
  #stopping = false;
  #owesFocus = false; // the button that goes on was not drawn yet when it was to get the focus
  #limit = el("p", { class: "muted" }); // of a pause: its seconds go on without the panel being built anew

  /** @param {Actions} actions */
  constructor(actions) {
    this.actions = actions;
  }

  /**
   * @param {Game} game @param {number} nowMs
   * @param {News} news
   * @param {readonly SeatCard[]} cards @param {Mapping} mapping
   */
  update(game, nowMs, news, cards, mapping) {
    if (this.#overlayKey === "over") return;
    this.#updateReady(game, news.busy, cards, mapping);
    if (news.lost) this.#say(news.lost, () => this.#show("lost", panel("", el("p", { role: "status" }, news.lost))));
    else this.#updateOverlay(game, nowMs, news, cards, mapping);
    this.#owesFocus = false;
  }

  /**
   * Gives the keyboard to what goes on from here: the button to be ready, or to continue after a pause, also one that
   * the next update draws.
   */
  focusAction() {
    const buttons = [this.#overlay, this.#ready].filter((box) => !box.hidden).map((box) => box.querySelector(ACTION));
    const button = buttons.find((one) => one !== null);
    this.#owesFocus = !button;
    if (button instanceof HTMLElement) button.focus();
    else if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
  }

  /** Asks for confirmation before stopping. */
  askStop() {
    if (this.actions.askStop) return this.actions.askStop();
    this.#stopping = true;
    this.#overlayKey = "";
  }

  /** Play goes on: the question is withdrawn. */
  forgetStop() {
    this.#stopping = false;
  }

  /** Answers the question with no; returns whether it was asked. */
  refuseStop() {
    const asked = this.#stopping;
    this.forgetStop();
    if (asked) this.#overlayKey = "?";
    return asked;
  }

  /**
   * Shows that the game is over for this page, why, and where to go.
   * @param {import("../wire/connection.js").Ending} ending
   * @param {string} watchPath empty: no such offer
   * @param {() => void} [here] plays on here what another tab plays
   */
  showOver({ kind, sentence }, watchPath, here) {
    const onward = wayOn(kind, here);
    const buttons = [
      onward,
      watchPath ? el("a", { class: "button", href: watchPath }, say("play.over.watch")) : null,
      el("a", { class: onward ? "button" : "button button-primary", href: "/" }, say("play.over.lobby")),
    ];
    this.#stopping = false; // Escape has nothing to answer any more
    this.#overlayKey = "over";
    this.#show("over", panel("", el("p", { role: "alert" }, sentence), el("div", { class: "row" }, ...buttons)));
    this.#ready.hidden = true;
  }

  // ---- the ready card --------------------------------------------------------------------------------------

  /** @param {Game} game @param {boolean} busy @param {readonly SeatCard[]} cards @param {Mapping} mapping */
  #updateReady(game, busy, cards, mapping) {
    const { room, round, own } = game;
    const visible =
      !busy && room !== null && round !== null && ["lobby", "round_over", "series_over"].includes(room.phase);
    const key = visible
      ? JSON.stringify([
          room.phase,
          game.result === null,
          heldText(room),
          room.seats.map((seat) => [seat.name, seat.open, seat.present, seat.ready, seat.visible]),
          own,
          cards,
          mapping,
        ])
      : "";
    if (key === this.#readyKey) return;
    this.#readyKey = key;
    this.#ready.hidden = !visible;
    if (!visible) return;
    const parts = this.#readyParts(game, room.seats, cards, mapping);
    const follows = cards.length < 2 && this.#ready.contains(document.activeElement);
    this.#ready.replaceChildren(el("div", { class: "stack" }, ...parts));
    if (follows) this.focusAction(); // the partner came while the link was copied
  }

  /**
   * @param {Game} game @param {readonly import("../messages.js").SeatState[]} seats
   * @param {readonly SeatCard[]} cards @param {Mapping} mapping
   */
  #readyParts(game, seats, cards, mapping) {
    if (game.overBeforeRound) return overBeforeRound(game);
    const open = seats.filter((seat) => seat.open);
    if (open.length === 0 || game.welcome === null) return this.#askReady(game, cards, mapping);
    return invitation(game.welcome, open, game.own.length === 0);
  }

  /** @param {Game} game @param {readonly SeatCard[]} cards @param {Mapping} mapping */
  #askReady(game, cards, mapping) {
    const { seats, phase } = game.room ?? { seats: [], phase: "lobby" };
    const waiting = seats
      .filter((seat, index) => !seat.ready && !game.own.includes(index))
      .map((seat) => el("p", { class: "muted small" }, waitingForText(seat, game.own.length === 0, phase)));
    const held = heldText(game.room);
    const why = held ? el("p", { class: "small", role: "status" }, held) : "";
    if (game.own.length === 0) return [el("h2", {}, say("play.ready.soon")), why, ...waiting];
    if (!this.actions.asksReady) return [el("h2", {}, say("study.play.starts")), why, ...waiting];
    const rows = cards.map((card) => this.#readyRow(card, seats[card.seat], mapping, cards));
    const mineReady = game.own.every((seat) => seats[seat]?.ready);
    const hint = game.round ? el("p", { class: "small" }, mapDescription(game.round.map)) : "";
    // Between rounds there is no other button to leave by, and the partner may never come back.
    const leave = isOver(phase) ? el("a", { class: "button", href: "/" }, say("play.over.lobby")) : "";
    const others = mineReady ? [...waiting, leave] : this.#whoWaits(game, seats);
    return [el("h2", {}, say("play.ready.title")), why || hint, ...rows, ...others];
  }

  /**
   * That the partner is ready, and whether they look at the game, which a phone shows nowhere else.
   * @param {Game} game @param {readonly import("../messages.js").SeatState[]} seats
   */
  #whoWaits(game, seats) {
    const waits = seats.find((seat, index) => seat.kind === "human" && seat.ready && !game.own.includes(index));
    if (!waits) return [];
    const told = say(waits.visible === false ? "play.ready.partnerAway" : "play.ready.partnerWaits");
    return [el("p", { class: "small", role: "status" }, told)];
  }

  /**
   * @param {SeatCard} card
   * @param {import("../messages.js").SeatState} seat
   * @param {Mapping} mapping
   * @param {readonly SeatCard[]} cards
   */
  #readyRow(card, seat, mapping, cards) {
    const several = cards.length > 1;
    const who = el(
      "p",
      { class: "agent" },
      badge(card.seat),
      several ? colourName(card.seat) : say("play.ready.you", { colour: colourWord(card.seat) }),
    );
    if (seat?.ready)
      return el("div", { class: "row row-apart" }, who, el("span", { class: "pill pill-ok" }, say("play.state.ready")));
    // The touch button is not shown yet: only the button below can be pressed.
    const press = card.device === "touch" ? null : el("p", { class: "muted small" }, whatToPress(card, mapping, cards));
    const button = el(
      "button",
      { type: "button", class: several ? "button button-small" : "button button-primary button-wide" },
      say("play.ready.button"),
    );
    button.addEventListener("click", () => this.actions.ready(card.seat));
    if (several) return el("div", {}, el("div", { class: "row row-apart" }, who, button), press);
    return el("div", { class: "stack" }, who, press, button);
  }

  // ---- over the arena --------------------------------------------------------------------------------------

  /**
   * @param {Game} game @param {number} nowMs @param {News} news
   * @param {readonly SeatCard[]} cards @param {Mapping} mapping
   */
  #updateOverlay(game, nowMs, news, cards, mapping) {
    const seconds = Math.ceil(game.secondsLeft(nowMs) - 0.05);
    if (this.#stopping) this.#say("stop", () => this.#ask("stop", this.#sure(game)));
    else if (game.phase === "paused") this.#updatePause(game, seconds, news, cards, mapping);
    else if (game.phase === "countdown") this.#say(`count ${seconds}`, () => this.#show("count", count(seconds)));
    else this.#say("", () => this.#hide());
  }

  /**
   * @param {Game} game @param {number} seconds @param {News} news
   * @param {readonly SeatCard[]} cards @param {Mapping} mapping
   */
  #updatePause(game, seconds, { deaf, hint }, cards, mapping) {
    const seats = game.room?.seats ?? [];
    const limit = pauseLimitText(game.room, seconds);
    const driven = cards.filter((card) => card.device !== "touch" && !isBesideTouch(card, cards));
    const asks = driven.filter((card) => !seats[card.seat]?.ready);
    const presses = asks.map((card) => {
      const who = cards.length > 1 ? `${colourName(card.seat)}: ` : "";
      return who + say("play.pause.goOn", { key: grabName(card, mapping) });
    });
    const unready = cards.map(({ seat }) => seat).filter((seat) => !seats[seat]?.ready);
    if (this.#limit.textContent !== limit) this.#limit.textContent = limit;
    const key = JSON.stringify([game.room?.reason, unready, hint, presses, deaf]);
    this.#say(key, () => this.#ask("pause", this.#pause(game, { hint, deaf }, presses, unready)));
  }

  /**
   * @param {Game} game @param {Pick<News, "hint" | "deaf">} news
   * @param {readonly string[]} presses @param {readonly number[]} unready seats of this page
   */
  #pause(game, { hint, deaf }, presses, unready) {
    const parts = [...reasons(game, hint), this.#limit];
    const quiet = deaf ? "muted invisible" : "muted"; // has its place from the start, so that no button moves
    for (const press of presses) parts.push(el("p", { class: quiet }, press));
    const buttons = [];
    if (unready.length > 0) {
      const goOn = () => unready.forEach((seat) => this.actions.ready(seat));
      buttons.push(
        el("button", { type: "button", class: "button button-primary", onclick: goOn }, say("play.pause.button")),
      );
    }
    if (game.own.length > 0)
      buttons.push(
        el(
          "button",
          { type: "button", class: "button", onclick: () => this.askStop() },
          say(this.actions.askStop ? "study.page.stop" : "play.pause.stop"),
        ),
      );
    return panel(say("play.pause.title"), ...parts, el("div", { class: "row" }, ...buttons));
  }

  /** @param {Game} game */
  #sure(game) {
    const people = game.room?.seats.filter(({ kind }) => kind === "human").length ?? 0;
    const no = () => this.refuseStop();
    const yes = () => {
      no();
      this.actions.stop();
    };
    return panel(
      say(people > 1 ? "play.pause.sure" : "play.pause.sureAlone"),
      el(
        "div",
        { class: "row" },
        el("button", { type: "button", class: "button button-danger", onclick: yes }, say("play.pause.yes")),
        el("button", { type: "button", class: "button", "data-safe": "", onclick: no }, say("play.pause.no")),
      ),
    );
  }

  /** @param {string} key @param {() => void} build */
  #say(key, build) {
    if (key === this.#overlayKey) return;
    this.#overlayKey = key;
    build();
  }

  /** @param {string} kind @param {HTMLElement} content */
  #show(kind, content) {
    this.#overlay.dataset.kind = kind;
    this.#overlay.replaceChildren(content);
    this.#overlay.hidden = false;
  }

  /**
   * Shows a question. It gets the keyboard if that was there or on the button that brought it: the button must not take
   * the key that answers. A button that was there before keeps the keyboard.
   * @param {string} kind @param {HTMLElement} content
   */
  #ask(kind, content) {
    const focused = document.activeElement;
    const inside = this.#overlay.contains(focused);
    this.#show(kind, content);
    const same = [...content.querySelectorAll("button")].find(({ textContent: name }) => name === focused?.textContent);
    if (inside && same) same.focus();
    else if (inside || focused?.id === "stop" || this.#owesFocus) this.focusAction();
  }

  #hide() {
    this.#overlay.hidden = true;
    this.#overlay.replaceChildren();
  }
}

/**
 * Fingers drive the other seat of this page: there may be nothing to drive this one.
 * @param {SeatCard} card @param {readonly SeatCard[]} cards
 */
function isBesideTouch({ device }, cards) {
  return device === "keyboard" && cards.some((card) => card.device === "touch");
}

/** @param {SeatCard} card @param {Mapping} mapping @param {readonly SeatCard[]} cards */
function whatToPress(card, mapping, cards) {
  const grab = grabName(card, mapping);
  if (!isBesideTouch(card, cards)) return say("play.ready.press", { key: grab });
  const move = card.keySets.map((set) => moveName(mapping.keys[set])).join(say("play.or"));
  return say("play.ready.needsDevice", { colour: colourName(card.seat), move, grab });
}

/**
 * Which gamepad is gone, and why the game waits, where that is not a pause for the gamepad.
 * @param {Game} game @param {string} hint
 */
function reasons({ room, own }, hint) {
  const told = hint ? [el("p", { role: "alert" }, hint)] : [];
  return hint && room?.reason_code === "paused" ? told : [...told, el("p", {}, reasonText(room, own))];
}

/** Nobody can be ready or invited any more: why, and the way out. @param {Game} game */
function overBeforeRound({ room, own }) {
  return [
    el("p", {}, reasonText(room, own)),
    el("a", { class: "button button-primary button-wide", href: "/" }, say("play.over.lobby")),
  ];
}

/**
 * What leads on where a game is over for this page; null: only the start page.
 * @param {string} kind of an ending @param {(() => void) | undefined} here
 */
function wayOn(kind, here) {
  const look = { type: "button", class: "button button-primary" };
  if (here) return el("button", { ...look, onclick: here }, say("play.elsewhere.here"));
  if (kind === "outdated") return el("button", { ...look, onclick: () => location.reload() }, say("play.over.reload"));
  if (kind === "notFound") return el("a", { class: "button button-primary", href: "/#play" }, say("lobby.now"));
  return null;
}

/** @param {string} title @param {...HTMLElement} parts */
function panel(title, ...parts) {
  const heading = title ? el("h2", {}, title) : null;
  return el("div", { class: "card card-roomy panel" }, el("div", { class: "stack" }, heading, ...parts));
}

/** @param {number} seconds */
function count(seconds) {
  return el("p", { class: "count" }, String(Math.max(1, seconds)));
}
