// @ts-check
/*
 * A finished round as a picture or an animation: handed to the device's own way of sharing on phones, saved elsewhere.
 */

import { canShare } from "../../components/link.js";
import { requestBlob } from "../../core/api.js";
import { el } from "../../core/dom.js";
import { currentLanguage, say, sayError } from "../../text/catalogue.js";

/** @typedef {{room: string, token: () => string, recording: string}} Shared  token: as it is at the press */

/** The two buttons, and what became of the last press. @param {Shared} shared */
export function shareButtons(shared) {
  const said = el("span", { class: "muted small", role: "status" });
  return el(
    "div",
    { class: "row" },
    button("picture", "png", shared, said),
    button("animation", "gif", shared, said),
    said,
  );
}

/**
 * @param {"picture" | "animation"} what @param {"png" | "gif"} kind
 * @param {Shared} shared @param {HTMLElement} said
 */
function button(what, kind, shared, said) {
  const text = say(`play.result.${what}${canShare() ? ".send" : ""}`);
  const press = el("button", { type: "button", class: "button button-small" }, text);
  press.addEventListener("click", async () => {
    if (press.getAttribute("aria-disabled") === "true") return;
    press.setAttribute("aria-disabled", "true"); // not `disabled`: the keyboard would lose its place
    said.textContent = say("play.result.drawing");
    said.textContent = await hand(kind, shared).catch(sayError);
    press.removeAttribute("aria-disabled");
  });
  return press;
}

/**
 * @param {"png" | "gif"} kind @param {Shared} shared
 * @returns {Promise<string>} what to say; ApiError when the server refuses
 */
async function hand(kind, { room, token, recording }) {
  const path = `/api/rooms/${room}/rounds/${recording}.${kind}?language=${currentLanguage()}`;
  const picture = await requestBlob(path, { token: token() });
  const file = new File([picture], `${say("play.result.fileName")}.${kind}`, { type: `image/${kind}` });
  if (canShare() && navigator.canShare?.({ files: [file] })) {
    const sent = await navigator.share({ files: [file] }).then(
      () => true,
      (/** @type {Error} */ error) => error.name === "AbortError", // closed without sending, as is everybody's right
    );
    if (sent) return "";
  }
  const address = URL.createObjectURL(file);
  el("a", { href: address, download: file.name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
  return say("play.result.saved");
}
