// @ts-check
/*
 * What the lobby says of an agent: a name and a sentence for whoever plays, and a line for researchers.
 */

import { has, say, sayNumber } from "../text/catalogue.js";
import { agentName } from "../text/names.js";

/** @typedef {import("./choice.js").AgentCard} AgentCard */

/** @param {AgentCard} agent */
export function partnerName({ id, name }) {
  return agentName(id, name || id);
}

/**
 * What to expect of a partner, in one or two plain sentences: of a trained one how much gets done with people it never
 * met; of another what the catalogue says of it, else the first sentence of its own description.
 * @param {AgentCard} agent
 */
export function partnerLine(agent) {
  const { id, tcr, description } = agent;
  const help = `agent.${id.split(/[@:]/)[0]}.help`;
  if (!isTrained(agent)) return has(help) ? say(help) : firstSentence(description);
  const what = say("lobby.partner.trained");
  if (typeof tcr?.unseen !== "number") return what;
  return `${what} ${say("lobby.partner.score", { percent: Math.round(100 * tcr.unseen) })}`;
}

/**
 * Of a trained agent what it is, whom it has learned from and its scores; empty for others.
 * @param {AgentCard} agent
 */
export function researchLine(agent) {
  if (!isTrained(agent)) return "";
  const { kind, policy: trained, population, tcr } = agent;
  const name = kindName(trained || kind || "");
  const wrapped = `lobby.policy.with.${kind}`;
  const policy = kind !== trained && has(wrapped) ? say(wrapped, { policy: name }) : name;
  const what = say("lobby.trained", { policy, population: populationText(population ?? "") });
  return typeof tcr?.unseen === "number" ? `${what} ${tcrText(tcr.unseen, tcr.alone)}` : what;
}

/** @param {AgentCard} agent */
function isTrained({ population }) {
  return Boolean(population);
}

/** A trained kind as researchers call it; one without a text is called by its own word. @param {string} kind */
function kindName(kind) {
  return has(`lobby.policy.${kind}`) ? say(`lobby.policy.${kind}`) : kind;
}

/** "scripted people of A and B; none of C": whose play it has learned from. @param {string} population */
function populationText(population) {
  const learned = population.split(";")[0];
  const key = `lobby.population.${learned.replaceAll(" ", "-")}`;
  return has(key) ? say(key) : learned;
}

/** @param {number} unseen @param {number | null} alone */
function tcrText(unseen, alone) {
  const values = { unseen: sayNumber(unseen, 2) };
  return alone === null ? say("lobby.tcr", values) : say("lobby.tcr.alone", { ...values, alone: sayNumber(alone, 2) });
}

/** A lobby has room for one line. @param {string} text */
function firstSentence(text) {
  return text.match(/^.*?[.!?](?= |$)/s)?.[0] ?? text; // older Safaris know no look behind
}
