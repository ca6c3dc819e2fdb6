// @ts-check
/*
 * Shown after creating a room without playing in it: the link and QR code for people, the address for programs, the
 * link to watch, until the room is gone. Knows what POST /api/rooms answers.
 */

import { ApiError, requestJson } from "../core/api.js";
import { el } from "../core/dom.js";
import { INVITED_S } from "../messages.js";
import { say } from "../text/catalogue.js";
import { PLAY_EVERYWHERE, linkButtons, loopbackWarning } from "./link.js";

/** @typedef {{room: string, join_path: string, watch_path: string}} Room */

const LOOK_MS = 10_000; // between two looks whether the room is still there

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
  const looking = setInterval(() => void isGone(room).then((gone) => (gone ? showGone() : undefined)), LOOK_MS);
  const showGone = () => {
    clearInterval(looking);
    const gone = el("p", { class: "notice notice-bad", role: "alert" }, say("lobby.share.gone"));
    container.replaceChildren(gone, el("div", { class: "row" }, back));
  };
  back.addEventListener("click", () => {
    clearInterval(looking);
    container.hidden = true;
    before.hidden = false;
  });
  const watch = el("a", { class: "button button-primary", href: room.watch_path }, say("lobby.share.watch"));
  const until = el("p", { class: "muted small" }, say("lobby.share.until", { minutes: INVITED_S / 60 }));
  container.replaceChildren(...parts, until, el("div", { class: "row" }, watch, back));
  before.hidden = true;
  container.hidden = false;
  heading.focus();
}

/** Whether the server has closed the room. @param {Room} room */
async function isGone({ room }) {
  return requestJson(`/api/rooms/${encodeURIComponent(room)}`).then(
    () => false,
    (error) => error instanceof ApiError && error.code === "no_room",
  );
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
