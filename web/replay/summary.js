// @ts-check
/*
 * The head of the replay page: which episode this is, how it ended, and who played.
 */

import { namedBadge } from "../components/named_badge.js";
import { byId, el } from "../core/dom.js";
import { outcomeText } from "../play/result/result_words.js";
import { currentLanguage, say } from "../text/catalogue.js";
import { mapTitle, replayedPlayer } from "../text/names.js";

/** @typedef {import("./data.js").Summary} Summary */

/** @param {Summary} summary @returns {HTMLElement[]} per seat the place for what it is doing */
export function showSummary(summary) {
  const title = mapTitle(summary.map);
  document.title = say("replay.pageTitle", { map: title });
  byId("title", HTMLElement).textContent = title;
  byId("when", HTMLElement).textContent = new Date(summary.started).toLocaleString(currentLanguage(), {
    dateStyle: "medium",
    timeStyle: "short",
  });
  byId("state", HTMLElement).replaceChildren(...pills(summary));
  byId("id", HTMLElement).textContent = summary.id;
  const words = summary.seats.map(() => el("p", { class: "replay-seat-words" }));
  const cards = summary.seats.map(({ name, kind }, index) =>
    el(
      "div",
      { class: "replay-seat" },
      namedBadge(index),
      el("span", { class: "replay-seat-name" }, replayedPlayer(kind, name)),
      words[index],
    ),
  );
  byId("seats", HTMLElement).replaceChildren(...cards);
  return words;
}

/** @param {Summary} summary */
function pills({ outcome, complete, exact, damage }) {
  const tone = outcome === "delivered" ? "pill-ok" : outcome === "error" ? "pill-bad" : "";
  const pill = (/** @type {string} */ text, kind = "pill-attention") => el("span", { class: `pill ${kind}` }, text);
  return [
    pill(outcomeText({ outcome }), tone),
    complete ? null : pill(say(damage ? "replay.damaged" : "replay.cutOff")),
    exact === false ? pill(say("replay.smoothed")) : null,
  ].filter((part) => part !== null);
}

/** A recorded seat in the shape of a live one. @param {Summary["seats"][number]} seat */
export function seatState({ colour, kind, name }) {
  return {
    colour,
    kind: /** @type {"human"} */ (kind),
    name,
    open: false,
    present: true,
    visible: true,
    ready: true,
    device: "",
    rtt_ms: -1,
  };
}
