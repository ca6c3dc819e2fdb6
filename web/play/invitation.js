// Shown while a seat is open: how the other player, or a program, can take it.

import { el } from "../core/dom.js";
import { PLAY_EVERYWHERE, linkButtons, loopbackWarning } from "../components/link.js";
import { programFacts } from "../components/share.js";
import { say } from "../text/catalogue.js";

/**
 * @param {import("../messages.js").Welcome} welcome @param {readonly import("../messages.js").SeatState[]} open
 * @param {boolean} watching
 */
export function invitation(welcome, open, watching) {
  if (watching)
    return [
      el("h2", {}, say("play.ready.soon")),
      el("p", { class: "muted small" }, say("play.waiting.seats", { count: open.length })),
    ];
  if (open.every(({ kind }) => kind === "remote"))
    return [el("h2", {}, say("play.waiting.program")), ...programFacts(welcome.room)];
  return shareLink(new URL(welcome.join_path, location.href).href, welcome.room);
}

/**
 * Invites the other player: a QR code, in sight also in a low window, the link, a button that copies it.
 * @param {string} link
 * @param {string} room
 */
function shareLink(link, room) {
  const field = el("input", {
    class: "input share-link",
    readonly: true,
    value: link,
    "aria-label": say("play.waiting.link"),
  });
  field.addEventListener("focus", () => field.select());
  const qr = el("img", {
    class: "qr",
    src: `/api/rooms/${room}/qr.svg`,
    alt: say("play.waiting.qr"),
    width: 128,
    height: 128,
  });
  return [
    el("h2", {}, say("play.waiting.title")),
    el("div", { class: "invite" }, el("p", { class: "muted small" }, say("play.waiting.sentence")), qr),
    field,
    linkButtons(link, document.title, true),
    loopbackWarning(link, PLAY_EVERYWHERE),
  ].filter((part) => part !== null);
}
