// @ts-check
/*
 * A decision of an agent in words: what it is trying, and the scores of its candidates with their ranks.
 */

import { el } from "../core/dom.js";
import { say, sayNumber } from "../text/catalogue.js";
import { colourName } from "../text/names.js";
import { ranksOf } from "./candidates.js";

/** @typedef {import("./candidates.js").Decision} Decision */
/** @typedef {import("./plan.js").Plan} Plan */
/** @typedef {import("./render.js").GameMap} GameMap */

/** What an agent is trying, in a sentence. @param {Plan} plan @param {number} seat @param {GameMap} map */
export function planSentence({ kind, item, hopes }, seat, map) {
  return say(`plan.${hopes ? "fetchHopes" : kind}.${map.items[item].size}`, {
    who: colourName(seat),
    partner: colourName(1 - seat),
  });
}

/**
 * The plan where it can be told, and a row per candidate, best first.
 * @param {Decision} decision @param {Plan | null} plan @param {GameMap} map
 */
export function decisionList(decision, plan, map) {
  const ranks = ranksOf(decision.scores);
  const rows = decision.scores
    .map((score, index) => ({ score, rank: ranks[index], chosen: index === decision.chosen }))
    .sort((one, other) => one.rank - other.rank)
    .map(({ score, rank, chosen }) =>
      el(
        "li",
        chosen ? { class: "decision-chosen" } : {},
        el("span", { class: "decision-rank" }, String(rank)),
        el("span", {}, sayNumber(score, 3)),
        chosen ? el("strong", {}, say("play.candidates.chosen")) : null,
      ),
    );
  return el(
    "div",
    { class: "decision" },
    el("p", { class: "label" }, say("plan.title", { who: colourName(decision.seat) })),
    plan ? el("p", {}, planSentence(plan, decision.seat, map)) : null,
    decision.scores.length > 1
      ? el("ol", { "aria-label": say("plan.scores", { who: colourName(decision.seat) }) }, ...rows)
      : null,
  );
}

/** A plan in the agent's own words. @param {{seat: number, plan: string}} told */
export function toldPlan({ seat, plan }) {
  return el(
    "div",
    { class: "decision" },
    el("p", { class: "label" }, say("plan.says", { who: colourName(seat) })),
    el("p", {}, plan),
  );
}

/** What ranks and scores mean. */
export function decisionLegend() {
  return el("p", { class: "muted small" }, say("plan.legend"));
}
