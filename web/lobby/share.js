// @ts-check
/*
 * The view after making a room in which its maker does not play: the link and code for people, the address for
 * programs, the way to watch. Knows what POST /api/rooms answers.
 */

import { el } from "../core/dom.js";

/** @typedef {{room: string, join_path: string, watch_path: string}} Room */

/**
 * @param {HTMLElement} container
 * @param {HTMLElement} before what it replaces on the page
 * @param {Room} room
 * @param {readonly string[]} seats values of the lobby's seat options
 */
export function showShare(container, before, room, seats) {
  const heading = el("h2", { tabindex: "-1" }, "The room is open");
  const parts = [heading];
  if (seats.includes("link")) parts.push(linkCard(room));
  if (seats.includes("remote")) parts.push(programCard(room));
  const back = el("button", { type: "button", class: "button" }, "Back to the maps");
  back.addEventListener("click", () => {
    container.hidden = true;
    before.hidden = false;
  });
  const watch = el("a", { class: "button button-primary", href: room.watch_path }, "Watch the game");
  container.replaceChildren(...parts, el("div", { class: "row" }, watch, back));
  before.hidden = true;
  container.hidden = false;
  heading.focus();
}

/** @param {Room} room */
function linkCard(room) {
  const address = new URL(room.join_path, location.href).href;
  const copy = el("button", { type: "button", class: "button" }, "Copy the link");
  const said = el("span", { class: "muted small", role: "status" });
  copy.addEventListener("click", async () => {
    const done = await navigator.clipboard?.writeText(address).then(
      () => true,
      () => false,
    );
    said.textContent = done ? "Copied." : "Copying is not allowed here: select the link above.";
  });
  return el(
    "div",
    { class: "card card-roomy share-link" },
    el(
      "div",
      { class: "stack" },
      el("h3", {}, "For a person"),
      el("p", {}, "Send this link, or let them scan the code. The game starts when everybody is ready."),
      el("a", { class: "share-address", href: address }, address),
      el("div", { class: "row" }, copy, said),
    ),
    el("img", {
      src: `/api/rooms/${encodeURIComponent(room.room)}/qr.svg`,
      alt: "QR code of the link",
      width: 160,
      height: 160,
    }),
  );
}

/** @param {Room} room */
function programCard({ room }) {
  return el("div", { class: "card card-roomy stack" }, el("h3", {}, "For a program"), ...programFacts(room));
}

/**
 * What a program needs to take a seat; the game page shows it too.
 * @param {string} room
 */
export function programFacts(room) {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  return [
    el("p", {}, "It connects to this address and joins this room. docs/protocol.md explains how, with an example."),
    el(
      "dl",
      { class: "facts" },
      el("dt", {}, "Address"),
      el("dd", {}, `${scheme}://${location.host}/ws`),
      el("dt", {}, "Room"),
      el("dd", {}, room),
    ),
  ];
}
