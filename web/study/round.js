// @ts-check
/*
 * Before, during and after a round, as seen from outside the game: the map card with who sits where, the wait for the
 * partner, the way back into a running round, the way on after it.
 */

import { actionButton, heading, problemBox } from "../components/action.js";
import { badge, el } from "../core/dom.js";
import { mapPicture } from "../view/render.js";
import { say } from "../text/catalogue.js";
import { mapDescription, mapTitle } from "../text/names.js";
import { card } from "./screen.js";

/** @typedef {import("./screen.js").Context} Context */
/** @typedef {import("./screen.js").Screen} Screen */
/** @typedef {import("./service.js").Step} Step */

const COLOURS = /** @type {const} */ (["blue", "red"]);

/** @param {Context} context @returns {Screen} */
export function roundScreen(context) {
  const state = context.step.state ?? "card";
  if (state === "playing") return runningScreen(context);
  if (state === "over") return overScreen(context);
  return cardScreen(context, state === "waiting");
}

/** @param {Step} step */
function title({ map, title: otherwise = "" }) {
  return map ? mapTitle({ name: map.name, title: otherwise }) : otherwise || undefined;
}

/** @param {Step} step */
function description({ map, description: otherwise = "" }) {
  return map ? mapDescription({ name: map.name, description: otherwise }) : otherwise;
}

/** "Round 3 of 12 · Partner A". @param {Step} step */
export function roundName(step) {
  const round =
    step.kind === "practice"
      ? say("study.round.practice")
      : say("study.round.of", { number: step.number ?? 1, total: step.of ?? 1 });
  return step.partner_letter ? `${round} · ${say("study.round.partner", { letter: step.partner_letter })}` : round;
}

/** @param {Context} context @param {boolean} waits @returns {Screen} */
function cardScreen(context, waits) {
  const { step, next } = context;
  const problem = problemBox();
  const picture = el("canvas", { class: "map-picture", role: "img", "aria-label": say("study.round.map") });
  const action = waits
    ? el("p", { class: "notice", role: "status" }, say("study.round.waiting"))
    : el(
        "div",
        { class: "row" },
        actionButton(say("study.round.ready"), problem, () => next()),
      );
  const facts = el(
    "div",
    { class: "stack" },
    el("ul", { class: "round-seats" }, ...seatLines(context)),
    step.kind === "practice" ? el("p", {}, say("study.round.practiceLead")) : null,
    el("p", {}, description(step) || say("study.round.goal")),
    marks(step.map),
    step.limit_s
      ? el(
          "p",
          {},
          el("span", { class: "muted" }, `${say("study.round.limit")} `),
          el("strong", {}, length(step.limit_s)),
        )
      : null,
    problem,
    action,
  );
  const root = card(
    heading(title(step) ?? say("study.round.practice"), roundName(step)),
    el("div", { class: "round-card" }, picture, facts),
  );
  const draw = () => step.map && picture.isConnected && mapPicture(picture, step.map);
  const observer = new ResizeObserver(draw); // draws once it has a size, and again when that changes
  observer.observe(picture);
  window.addEventListener("movingout-theme", draw);
  const close = () => {
    observer.disconnect();
    window.removeEventListener("movingout-theme", draw);
  };
  return { root, close };
}

/** @param {number} seconds */
function length(seconds) {
  return seconds % 60 === 0
    ? say("study.round.minutes", { minutes: seconds / 60 })
    : say("study.round.seconds", { seconds });
}

/** What the marks on the items of this map mean. @param {Step["map"]} map */
function marks(map) {
  const sizes = new Set(map?.items.map(({ size }) => size));
  const sentences = ["large", "middle"]
    .filter((size) => sizes.has(size))
    .map((size) => say(`study.round.marks.${size}`));
  return sentences.length > 0 ? el("p", { class: "muted small" }, sentences.join(" ")) : null;
}

/** @param {Context} context */
function seatLines({ step, steps, people, several }) {
  const colour = (/** @type {number} */ seat) => say(`study.round.${COLOURS[seat]}`);
  const line = (/** @type {number} */ seat, /** @type {string} */ text) =>
    el("li", { class: "agent" }, badge(seat), el("span", {}, text));
  if (people.length > 1) {
    const lines = steps.map(({ seat }, index) => ({
      seat: seat ?? index,
      text: say("study.round.personIs", { number: people[index] + 1, colour: colour(seat ?? index) }),
    }));
    return lines.sort((a, b) => a.seat - b.seat).map(({ seat, text }) => line(seat, text));
  }
  const seat = step.seat ?? 0;
  const partner = step.partner_letter
    ? say("study.round.partner", { letter: step.partner_letter })
    : say("study.round.otherPerson");
  const own = several
    ? say("study.round.personIs", { number: people[0] + 1, colour: colour(seat) })
    : say("study.round.youAre", { colour: colour(seat) });
  return [
    el("li", { class: "agent strong" }, badge(seat), own),
    line(1 - seat, say("study.round.partnerIs", { partner, colour: colour(1 - seat) })),
  ];
}

/** @param {Context} context @returns {Screen} */
function runningScreen({ step, next, play }) {
  const problem = problemBox();
  const back = step.room
    ? el("button", { type: "button", class: "button button-primary", onclick: play }, say("study.round.backToGame"))
    : el("p", { class: "notice", role: "status" }, say("study.round.starting"));
  const enough =
    step.kind === "practice" ? actionButton(say("study.round.enough"), problem, () => next({ done: true }), "") : null;
  return {
    root: card(
      heading(say("study.round.runningTitle"), roundName(step)),
      el("p", { class: "lead" }, say("study.round.running")),
      problem,
      el("div", { class: "row" }, back, enough),
    ),
  };
}

/** @param {Context} context @returns {Screen} */
function overScreen({ step, next }) {
  const problem = problemBox();
  const on = actionButton(say("study.page.goOn"), problem, () => next());
  return {
    root: card(
      heading(say("study.round.overTitle"), roundName(step)),
      el("p", { class: "lead" }, say("study.round.over")),
      problem,
      el("div", { class: "row" }, on),
    ),
  };
}
