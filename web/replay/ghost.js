// @ts-check
// Playing with a recording: a person takes one seat, the other repeats its recorded actions (a ghost).

import { badge, el, notice } from "../core/dom.js";
import { openRoom } from "../wire/open_room.js";
import { say, sayError } from "../text/catalogue.js";
import { colourName } from "../text/names.js";

/**
 * The body of POST /api/rooms: the map is the recording's own.
 * @param {string} recording episode id
 * @param {number} own the person's seat
 * @param {number} limitTicks 0 for the usual limit
 */
export function ghostRequest(recording, own, limitTicks) {
  const seats = [0, 1].map((seat) => (seat === own ? { kind: "here" } : { kind: "ghost", recording }));
  return { maps: [], seats, ...(limitTicks > 0 && { limit_ticks: limitTicks }) };
}

/**
 * One button per seat, and the reason when the server refuses.
 * @param {HTMLElement} box @param {string} recording @param {number} limitTicks
 */
export function offerGhosts(box, recording, limitTicks) {
  const problem = el("div", { role: "alert" });
  const buttons = [0, 1].map((own) =>
    el(
      "button",
      { type: "button", class: "button button-small", onclick: () => void play(own) },
      badge(own),
      el("span", { "aria-hidden": "true" }, colourName(own)),
      el("span", { class: "sr-only" }, say("play.ghost.take", { colour: colourName(own) })),
    ),
  );
  box.replaceChildren(el("p", { class: "row" }, ...buttons), problem);

  /** @param {number} own */
  async function play(own) {
    for (const button of buttons) button.disabled = true;
    try {
      const room = await openRoom(ghostRequest(recording, own, limitTicks));
      location.assign(room.join_path);
    } catch (error) {
      problem.replaceChildren(notice("bad", sayError(error)));
    } finally {
      for (const button of buttons) button.disabled = false;
    }
  }
}
