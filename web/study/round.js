// @ts-check
/*
 * The screens around a round: before it the map and who plays which robot, the wait for the partner, the link back into
 * a running round, and what follows.
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
function title({ map, map_named: named, title: otherwise = "" }) {
  return map && !named ? mapTitle({ name: map.name, title: otherwise }) : otherwise || undefined;
}

/** @param {Step} step */
function description({ map, map_named: named, description: otherwise = "" }) {
  return map && !named ? mapDescription({ name: map.name, description: otherwise }) : otherwise;
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
  const { step } = context;
  const { picture, close } = mapCanvas(step.map);
  const root = card(
    heading(title(step) ?? say("study.round.practice"), roundName(step)),
    el("div", { class: "round-card" }, picture, roundFacts(context, waits)),
  );
  return { root, close };
}

/** @param {Context} context @param {boolean} waits */
function roundFacts(context, waits) {
  const { step, next } = context;
  const problem = problemBox();
  const action = waits
    ? el("p", { class: "notice", role: "status" }, say("study.round.waiting"))
    : el(
        "div",
        { class: "row round-action" },
        actionButton(say("study.round.ready"), problem, () => next()),
      );
  return el(
    "div",
    { class: "stack round-facts" },
    el("ul", { class: "round-seats" }, ...seatLines(context)),
    step.kind === "practice"
      ? el("p", {}, say(step.tutorial ? "study.round.tutorialLead" : "study.round.practiceLead"))
      : null,
    step.tutorial ? null : el("p", {}, description(step) || say("study.round.goal")),
    marks(step.map),
    step.limit_s && !step.tutorial ? limitLine(step.limit_s) : null,
    problem,
    action,
  );
}

/** @param {number} limitS seconds */
function limitLine(limitS) {
  return el("p", {}, el("span", { class: "muted" }, `${say("study.round.limit")} `), el("strong", {}, length(limitS)));
}

/** A picture of the map that follows its size on the page and the theme. @param {Step["map"]} map */
function mapCanvas(map) {
  const picture = el("canvas", { class: "map-picture", role: "img", "aria-label": say("study.round.map") });
  const draw = () => map && picture.isConnected && mapPicture(picture, map);
  const observer = new ResizeObserver(draw); // draws once the canvas has a size, and when that changes
  observer.observe(picture);
  window.addEventListener("movingout-theme", draw);
  const close = () => {
    observer.disconnect();
    window.removeEventListener("movingout-theme", draw);
  };
  return { picture, close };
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
