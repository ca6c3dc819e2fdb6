// Shown while a seat is open, also to those who watch: how another player, or a program, can take it.

import { el } from "../core/dom.js";
import { PLAY_EVERYWHERE, linkButtons, loopbackWarning } from "../components/link.js";
import { programFacts } from "../components/share.js";
import { say } from "../text/catalogue.js";

/**
 * @param {import("../messages.js").Welcome} welcome @param {readonly import("../messages.js").SeatState[]} open
 * @param {boolean} watching
 */
export function invitation(welcome, open, watching) {
  const link = new URL(welcome.join_path, location.href).href;
  const person = open.some(({ kind }) => kind !== "remote");
  if (watching) {
    const free = say("play.waiting.seats", { count: open.length });
    if (person) return shareLink(link, welcome.room, say("play.ready.soon"), free);
    const lead = el("p", { class: "muted small" }, free);
    return [el("h2", {}, say("play.ready.soon")), lead, ...programFacts(welcome.room)];
  }
  if (!person) return [el("h2", {}, say("play.waiting.program")), ...programFacts(welcome.room)];
  return shareLink(link, welcome.room, say("play.waiting.title"), say("play.waiting.sentence"));
}

/**
 * Invites a player: a QR code, in sight also in a low window, the link, a button that copies it.
 * @param {string} link
 * @param {string} room
 * @param {string} title
 * @param {string} sentence
 */
function shareLink(link, room, title, sentence) {
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
    el("h2", {}, title),
    el("div", { class: "invite" }, el("p", { class: "muted small" }, sentence), qr),
    field,
    linkButtons(link, document.title, true),
    loopbackWarning(link, PLAY_EVERYWHERE),
  ].filter((part) => part !== null);
}
