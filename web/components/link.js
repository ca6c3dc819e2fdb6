// @ts-check
/*
 * A link for somebody else: buttons that copy it or hand it to the device's own way of sharing, and a warning where
 * only this device can open it.
 */

import { el } from "../core/dom.js";
import { say } from "../text/catalogue.js";

export const PLAY_EVERYWHERE = "movingout play --host 0.0.0.0 --tls";
export const SERVE_EVERYWHERE = "movingout study serve FILE --host 0.0.0.0 --tls";

const LOOPBACK = [/^localhost$/, /\.localhost$/, /^\[::1\]$/, /^127(\.\d+){3}$/];

/** Whether only this machine can open an address. @param {string} address */
export function isLoopback(address) {
  const { hostname } = new URL(address);
  return LOOPBACK.some((shape) => shape.test(hostname));
}

/**
 * A warning beside a link that others cannot open; null where they can.
 * @param {string} address @param {string} command what starts the server for everybody
 */
export function loopbackWarning(address, command) {
  if (!isLoopback(address)) return null;
  return el(
    "div",
    { class: "notice notice-attention small stack loopback" },
    el("p", {}, say("share.loopback")),
    el("code", {}, ...command.split(" ").flatMap((word) => [el("span", {}, word), " "])),
  );
}

/** Whether the device has a way of sharing of its own worth a button: phones and tablets have. */
export function canShare() {
  return typeof navigator.share === "function" && matchMedia("(pointer: coarse)").matches;
}

/**
 * "Send the link…" on phones, and "Copy the link"; says whether copying worked.
 * @param {string} address @param {string} title of what is shared @param {boolean} [primary] the view's main action
 */
export function linkButtons(address, title, primary = false) {
  const main = (/** @type {boolean} */ yes) => (yes ? "button button-primary" : "button");
  const sends = canShare();
  const said = el("span", { class: "muted small", role: "status" });
  const copy = el("button", { type: "button", class: main(primary && !sends) }, say("lobby.share.copy"));
  copy.addEventListener("click", async () => {
    const done = await navigator.clipboard?.writeText(address).then(
      () => true,
      () => false,
    );
    said.textContent = say(done ? "lobby.share.copied" : "lobby.share.copyNot");
  });
  return el("div", { class: "row" }, sends ? sendButton(address, title, main(primary)) : null, copy, said);
}

/** @param {string} url @param {string} title @param {string} look */
function sendButton(url, title, look) {
  // Closing the device's dialog without sending is no failure.
  const send = () => void navigator.share({ title, url }).catch(() => {});
  return el("button", { type: "button", class: look, onclick: send }, say("share.send"));
}
