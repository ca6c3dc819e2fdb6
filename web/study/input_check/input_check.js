// @ts-check
/*
 * The check of controls and connection before the first round: what is pressed lights up, and the round trip is
 * measured. Reads the devices through the same modules as the game.
 */

import { actionButton, heading, problemBox, runAction, showProblem } from "../../components/action.js";
import { lastingStorage } from "../../core/browser_storage.js";
import { badge, el } from "../../core/dom.js";
import { roundTripTone } from "../../core/round_trip.js";
import { Gamepads } from "../../input/gamepad.js";
import { Keyboard } from "../../input/keyboard.js";
import { buttonName, keyName, loadMapping, moveName } from "../../input/mapping.js";
import { PadMemory, STUDY_PADS } from "../../input/pad_memory.js";
import { LocalSeats } from "../../input/seats.js";
import { Touch } from "../../input/touch.js";
import { measureRtt } from "./rtt.js";
import { card } from "../screen.js";
import { say } from "../../text/catalogue.js";
import { TriedControls } from "./tried_controls.js";

/** @typedef {import("../screen.js").Context} Context */
/** @typedef {import("../screen.js").Screen} Screen */
/** @typedef {import("../../input/seats.js").SeatReading} SeatReading */
/** @typedef {import("../../input/seats.js").SeatCard} SeatCard */

const LIT_MS = 180; // how long a short press stays lit

/** @param {Context} context @returns {Screen} */
export function inputCheckScreen(context) {
  return new InputCheck(context);
}

class InputCheck {
  #mapping = loadMapping(lastingStorage());
  #keyboard = new Keyboard(
    window,
    () => (this.#open ? this.#mapping.keys : []),
    () => this.#read(performance.now()),
    (code) => this.#isAwaited(code),
  );
  #gamepads = new Gamepads(() => navigator.getGamepads?.() ?? []);
  #problem = problemBox();
  #said = el("p", { role: "status" });
  #lacking = el("div", { class: "stack stack-tight" });
  #pill = el("span", { class: "pill", role: "status" });
  #rtt = NaN;
  /** @type {Promise<void> | null} */
  #measuring = null;
  #open = true;

  /** @param {Context} context */
  constructor(context) {
    const { people } = context;
    this.context = context;
    this.panels = people.map((_, seat) => new ControlPanel(seat, people.length > 1));
    this.touch = new Touch(this.panels[0].touchParts, () => {});
    const first = matchMedia("(pointer: coarse)").matches ? "touch" : "keyboard";
    const devices = { keyboard: this.#keyboard, gamepads: this.#gamepads, touch: this.touch };
    this.seats = new LocalSeats(devices, first, new PadMemory(STUDY_PADS));
    this.seats.hold(people.map((_, seat) => seat));
    this.tried = context.kept.tried ??= people.map(() => new TriedControls(context.step.gamepad_required === true));
    this.root = this.#build();
    this.#showTodo();
    void this.#measure();
    requestAnimationFrame((now) => this.#frame(now));
  }

  close() {
    this.#open = false; // the keyboard stays attached, but its keys no longer count
  }

  #build() {
    const { context } = this;
    const lead = say(
      context.step.gamepad_required
        ? "study.check.gamepad"
        : context.people.length > 1
          ? "study.check.leadTwo"
          : matchMedia("(pointer: coarse)").matches
            ? "study.check.leadTouch"
            : "study.check.lead",
    );
    this.goOn = actionButton(say("study.page.goOn"), this.#problem, () => this.#next());
    this.#lacking.append(...this.#wayOut());
    this.again = el("button", { type: "button", class: "button button-small" }, say("study.check.again"));
    this.again.addEventListener("click", () => void this.#measure());
    const connection = el(
      "div",
      { class: "row row-apart check-connection" },
      el("span", { class: "label" }, say("study.check.connection")),
      el("span", { class: "row" }, this.#pill, this.again),
    );
    const panels = el("div", { class: "check-panels" }, ...this.panels.map(({ root }) => root));
    panels.addEventListener("pointerdown", () => this.#read(performance.now())); // a tap may be shorter than a frame
    return card(
      heading(say("study.check.title")),
      el("p", { class: "lead" }, lead),
      panels,
      el("div", { class: "stack stack-tight" }, this.#said, this.#lacking),
      connection,
      this.#problem,
      el("div", { class: "row" }, this.goOn),
    );
  }

  /** @param {number} nowMs */
  #frame(nowMs) {
    if (!this.#open) return;
    requestAnimationFrame((next) => this.#frame(next));
    this.#read(nowMs);
  }

  /** On every frame and every key event, so that the shortest press counts. @param {number} nowMs */
  #read(nowMs) {
    const cards = this.seats.cards();
    for (const [seat, reading] of this.seats.read(this.#mapping)) {
      this.panels[seat].show(reading, cards[seat], this.#mapping, nowMs);
      if (this.tried[seat].add(reading)) this.#showTodo();
    }
  }

  /** What is still to be tried, and of two people by whom; empty when everything was. */
  #todo() {
    const todo = this.tried.map((one) => one.todo.map((what) => say(`study.check.${what}`)));
    if (todo.length === 1) return todo[0].length > 0 ? say("study.check.todo", { list: todo[0] }) : "";
    return todo
      .map((list, seat) => (list.length > 0 ? say("study.check.todoOf", { number: seat + 1, list }) : ""))
      .filter(Boolean)
      .join(" ");
  }

  #showTodo() {
    const todo = this.#todo();
    const all = todo === "";
    this.#said.textContent = all ? say("study.check.done") : todo;
    this.#said.className = all ? "check-done" : "";
    this.#lacking.hidden = all;
    if (this.goOn) this.goOn.disabled = !all;
    this.panels.forEach((panel, seat) => panel.showDone(this.tried[seat].done));
  }

  /** For whom a control does not work: the check is passed without it, and what was not tried is kept. */
  #wayOut() {
    const ask = el("button", { type: "button", class: "button-link small" }, say("study.check.lacking"));
    const without = actionButton(say("study.check.without"), this.#problem, () => this.#next(), "");
    const box = el(
      "div",
      { class: "stack stack-tight", hidden: true },
      el("p", { class: "muted small" }, say("study.check.lackingHelp")),
      el("div", { class: "row" }, without),
    );
    ask.setAttribute("aria-expanded", "false");
    ask.addEventListener("click", () => {
      box.hidden = !box.hidden;
      ask.setAttribute("aria-expanded", String(!box.hidden));
    });
    return [el("div", { class: "row" }, ask), box];
  }

  /** Whether a key is a grab key that somebody still has to try: no button takes it until then. @param {string} code */
  #isAwaited(code) {
    return this.seats
      .cards()
      .some(
        ({ seat, keySets }) =>
          this.tried[seat].awaits("grab") && keySets.some((set) => this.#mapping.keys[set].grab === code),
      );
  }

  /** Going on during a measurement waits for its result. */
  #measure() {
    this.#measuring ??= this.#measureOnce().finally(() => {
      this.#measuring = null;
    });
    return this.#measuring;
  }

  async #measureOnce() {
    this.#pill.className = "pill";
    this.#pill.textContent = say("study.check.measuring");
    if (!this.again) return;
    await runAction(this.again, this.#problem, async () => {
      this.#rtt = await measureRtt();
      const slow = this.#tooSlow();
      const tone = slow ? "bad" : roundTripTone(this.#rtt);
      const ms = Math.max(1, Math.round(this.#rtt));
      this.#pill.className = `pill pill-${tone}`;
      this.#pill.textContent = say(tone === "ok" ? "study.check.good" : "study.check.slow", { ms });
      if (slow) showProblem(this.#problem, say("study.check.tooSlow", { ms, most: this.context.step.rtt_ms ?? 0 }));
    });
  }

  #tooSlow() {
    const most = this.context.step.rtt_ms ?? 0;
    return most > 0 && this.#rtt > most;
  }

  async #next() {
    if (Number.isNaN(this.#rtt)) await this.#measure();
    if (Number.isNaN(this.#rtt)) return;
    // The server is told of a slow connection too: a participant who then stops is screened out, and paid as such.
    const rtt = Math.round(this.#rtt * 10) / 10;
    const cards = this.seats.cards();
    await this.context.next(cards.map(({ seat, device }) => ({ rtt_ms: rtt, device, untried: this.tried[seat].todo })));
  }
}

/** The picture of one person's controls. */
class ControlPanel {
  /** @param {number} seat @param {boolean} named */
  constructor(seat, named) {
    this.litUntil = 0;
    this.dot = el("div", { class: "check-dot" });
    this.zone = el("div", { class: "check-stick" }, this.dot);
    this.arrows = new Map(
      /** @type {const} */ (["up", "left", "down", "right"]).map((side) => [
        side,
        el("span", { class: `check-arrow check-${side}` }, say(`study.check.${side}`)),
      ]),
    );
    this.grab = el("button", { type: "button", class: "button check-light", tabindex: "-1" }, say("study.check.grab"));
    this.backward = el(
      "button",
      { type: "button", class: "button check-light", tabindex: "-1", "aria-pressed": "false" },
      say("study.check.backward"),
    );
    this.device = el("span", { class: "pill" });
    this.hint = el("p", { class: "muted small" });
    const who = named
      ? el("p", { class: "agent label" }, badge(seat), say("study.page.person", { number: seat + 1 }))
      : null;
    this.root = el(
      "div",
      { class: "check-panel" },
      el("div", { class: "row row-apart" }, who, this.device),
      el(
        "div",
        { class: "check-picture" },
        el("div", { class: "check-cross" }, this.zone, ...this.arrows.values()),
        el("div", { class: "check-buttons" }, this.grab, this.backward),
      ),
      this.hint,
    );
  }

  get touchParts() {
    return { zone: this.zone, knob: this.dot, grab: this.grab, backward: this.backward };
  }

  /**
   * @param {SeatReading} reading
   * @param {SeatCard} card
   * @param {import("../../input/mapping.js").Mapping} mapping
   * @param {number} nowMs
   */
  show({ stick, backward, grabs, device }, card, mapping, nowMs) {
    if (grabs > 0) this.litUntil = nowMs + LIT_MS;
    this.dot.style.setProperty("--x", stick.x.toFixed(2));
    this.dot.style.setProperty("--y", (-stick.y).toFixed(2));
    const lit = { up: stick.y > 0.4, down: stick.y < -0.4, left: stick.x < -0.4, right: stick.x > 0.4 };
    for (const [side, arrow] of this.arrows) arrow.toggleAttribute("data-lit", lit[side]);
    this.grab.toggleAttribute("data-lit", nowMs < this.litUntil);
    this.backward.toggleAttribute("data-lit", backward);
    const name =
      card.device === "gamepad" && card.pad ? card.pad.id.replace(/\s*\(.*$/, "") : say(`study.check.device.${device}`);
    if (this.device.textContent !== name) this.device.textContent = name;
    const hint = hintText({ ...card, device }, mapping);
    if (this.hint.textContent !== hint) this.hint.textContent = hint;
  }

  /** @param {ReadonlySet<string>} done */
  showDone(done) {
    for (const [side, arrow] of this.arrows) arrow.toggleAttribute("data-done", done.has(side));
    this.grab.toggleAttribute("data-done", done.has("grab"));
    this.backward.toggleAttribute("data-done", done.has("backward"));
  }
}

/**
 * @param {SeatCard} card
 * @param {import("../../input/mapping.js").Mapping} mapping
 */
function hintText({ device, keySets }, mapping) {
  if (device === "gamepad") {
    return say("study.check.hint.gamepad", {
      grab: buttonName(mapping.buttons.grab),
      backward: buttonName(mapping.buttons.backward),
    });
  }
  if (device === "touch") return say("study.check.hint.touch");
  const or = say("study.check.or");
  const sets = keySets.map((set) => mapping.keys[set]);
  const list = (/** @type {(keys: import("../../input/mapping.js").KeySet) => string} */ name) =>
    sets.map(name).join(or);
  return say("study.check.hint.keyboard", {
    move: list(moveName),
    grab: list(({ grab }) => keyName(grab)),
    backward: list(({ backward }) => keyName(backward)),
  });
}
