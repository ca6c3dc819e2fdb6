// The tutorial on the game page: the step to do in words for the device in use, the marks over the arena, the way out,
// and what follows. The steps themselves are judged by the server.

import { byId, el } from "../core/dom.js";
import { buttonName, keyName, moveName } from "../input/mapping.js";
import { say } from "../text/catalogue.js";
import { grabName } from "./hud.js";

/** @typedef {import("./game.js").Game} Game */
/** @typedef {import("../messages.js").Tutorial} Tutorial */
/** @typedef {import("../input/seats.js").SeatCard} SeatCard */
/** @typedef {import("../input/mapping.js").Mapping} Mapping */
/** @typedef {{skip(): void, again(): void}} Actions */

export class TutorialView {
  #play = byId("play", HTMLElement);
  #box = byId("tutorial", HTMLElement);
  #overlay = el("div", { class: "overlay overlay-end", hidden: true });
  #skip = el("button", { type: "button", class: "button button-wide play-enough" }, say("play.tutorial.skip"));
  #step = el("p", { class: "muted small" });
  #dots = el("p", { class: "tutorial-dots", "aria-hidden": "true" });
  #words = el("p", { class: "tutorial-words", role: "status" });
  #written = "";

  /** @param {Actions} actions @param {boolean} study  a study has its own way out and its own end */
  constructor(actions, study) {
    this.actions = actions;
    this.study = study;
    this.#box.append(el("div", { class: "row row-apart" }, this.#step, this.#dots), this.#words);
    byId("arena-box", HTMLElement).append(this.#overlay);
    this.#skip.addEventListener("click", () => actions.skip());
  }

  /** Whether the end covers the arena. */
  get showsResult() {
    return !this.#overlay.hidden;
  }

  /** Whoever stops here leaves the page. */
  stopHere() {
    location.assign("/");
  }

  /** After each change of the room. @param {Game} game */
  update(game) {
    const over = game.phase === "series_over" && !this.study;
    if (over === this.showsResult) return;
    this.#overlay.hidden = !over;
    if (over) this.#showEnd(game);
  }

  /** @param {Game} game @param {readonly SeatCard[]} cards @param {Mapping} mapping */
  write(game, cards, mapping) {
    const { tutorial } = game;
    this.#box.hidden = tutorial === null;
    this.#play.toggleAttribute("data-tutorial", tutorial !== null);
    if (tutorial === null) return;
    const offersSkip = !this.study && game.own.length > 0 && !game.phase.endsWith("_over");
    if (offersSkip && !this.#skip.isConnected) this.#offerSkip();
    this.#skip.hidden = !offersSkip;
    const words = tutorialWords(tutorial, cards, mapping);
    if (words === this.#written) return;
    this.#written = words;
    const { number, total, finished } = tutorial;
    this.#step.textContent = say("play.tutorial.step", { number, total });
    this.#dots.replaceChildren(
      ...Array.from({ length: total }, (_, index) =>
        el("span", { class: finished || index + 1 < number ? "done" : index + 1 === number ? "now" : "" }),
      ),
    );
    this.#words.textContent = words;
  }

  #offerSkip() {
    const stop = byId("stop", HTMLElement);
    stop.before(this.#skip);
    stop.parentElement?.classList.add("stack");
  }

  /** @param {Game} game */
  #showEnd(game) {
    const learned = game.tutorial?.finished === true;
    const heading = el("h2", { tabindex: "-1" }, say(learned ? "play.tutorial.end" : "play.tutorial.stopped"));
    const again = el("button", { type: "button", class: "button", onclick: () => this.actions.again() });
    again.textContent = say("play.tutorial.again");
    const play = el("a", { class: "button button-primary", href: "/#play" }, say("play.tutorial.play"));
    const choose = el("a", { class: "button", href: "/" }, say("play.tutorial.choose"));
    this.#overlay.replaceChildren(
      el(
        "section",
        { class: "card card-roomy stack panel" },
        heading,
        learned ? el("p", {}, say("play.tutorial.endHelp")) : null,
        el("div", { class: "row" }, play, game.own.length > 0 ? again : null, choose),
      ),
    );
    heading.focus({ preventScroll: true });
  }
}

/**
 * What to do now, for the device in use; of two people at one screen, what both are to do.
 * @param {Tutorial} tutorial @param {readonly SeatCard[]} cards @param {Mapping} mapping
 */
export function tutorialWords(tutorial, cards, mapping) {
  if (tutorial.finished) return say("play.tutorial.finished");
  const open = cards.filter(({ seat }) => !tutorial.done[seat]);
  if (cards.length > 0 && open.length === 0) return say("play.tutorial.waiting");
  const devices = new Set(open.map(({ device }) => device));
  const device = devices.size === 1 ? [...devices][0] : "keyboard";
  const names = open.map((card) => controlNames(card, mapping));
  const joined = (/** @type {"move" | "grab" | "backward"} */ control) =>
    [...new Set(names.map((name) => name[control]))].join(say("play.or"));
  const keys = { move: joined("move"), grab: joined("grab"), backward: joined("backward") };
  return say(`play.tutorial.${tutorial.step}.${device === "touch" ? "touch" : "keys"}`, keys);
}

/** @param {SeatCard} card @param {Mapping} mapping */
function controlNames(card, mapping) {
  const grab = grabName(card, mapping);
  if (card.device === "gamepad")
    return { move: say("button.leftStick"), grab, backward: buttonName(mapping.buttons.backward) };
  const sets = card.keySets.map((set) => mapping.keys[set]);
  return {
    move: sets.map(moveName).join(say("play.or")),
    grab,
    backward: [...new Set(sets.map((keys) => keyName(keys.backward)))].join(say("play.or")),
  };
}
