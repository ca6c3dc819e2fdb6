// @ts-check
/*
 * Shown after creating a room without playing in it: the link and QR code for people, the address for programs, the
 * link to watch. Knows what POST /api/rooms answers.
 */

import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";
import { PLAY_EVERYWHERE, linkButtons, loopbackWarning } from "./link.js";

/** @typedef {{room: string, join_path: string, watch_path: string}} Room */

/**
 * @param {HTMLElement} container
 * @param {HTMLElement} before what it replaces on the page
 * @param {Room} room
 * @param {readonly string[]} seats values of the lobby's seat options
 */
export function showShare(container, before, room, seats) {
  const heading = el("h2", { tabindex: "-1" }, say("lobby.share.title"));
  const parts = [heading];
  if (seats.includes("link")) parts.push(linkCard(room));
  if (seats.includes("remote")) parts.push(programCard(room));
  const back = el("button", { type: "button", class: "button" }, say("lobby.share.back"));
  back.addEventListener("click", () => {
    container.hidden = true;
    before.hidden = false;
  });
  const watch = el("a", { class: "button button-primary", href: room.watch_path }, say("lobby.share.watch"));
  container.replaceChildren(...parts, el("div", { class: "row" }, watch, back));
  before.hidden = true;
  container.hidden = false;
  heading.focus();
}

/** @param {Room} room */
function linkCard(room) {
  const address = new URL(room.join_path, location.href).href;
  return el(
    "div",
    { class: "card card-roomy share-link" },
    el(
      "div",
      { class: "stack" },
      el("h3", {}, say("lobby.share.person")),
      el("p", {}, say("lobby.share.person.help")),
      el("a", { class: "share-address", href: address }, address),
      linkButtons(address, document.title),
      loopbackWarning(address, PLAY_EVERYWHERE),
    ),
    el("img", {
      src: `/api/rooms/${encodeURIComponent(room.room)}/qr.svg`,
      alt: say("play.waiting.qr"),
      width: 160,
      height: 160,
    }),
  );
}

/** @param {Room} room */
function programCard({ room }) {
  return el("div", { class: "card card-roomy stack" }, el("h3", {}, say("lobby.share.program")), ...programFacts(room));
}

/**
 * What a program needs to take a seat; the game page shows it too.
 * @param {string} room
 */
export function programFacts(room) {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  return [
    el("p", {}, say("play.program.lead")),
    el(
      "dl",
      { class: "facts" },
      el("dt", {}, say("play.program.address")),
      el("dd", {}, `${scheme}://${location.host}/ws/${room}`),
      el("dt", {}, say("play.program.room")),
      el("dd", {}, room),
    ),
  ];
}
