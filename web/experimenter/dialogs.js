// @ts-check
/*
 * The dialogs of the experimenter: reasons for an action, and the link for the next participant.
 */

import { SERVE_EVERYWHERE, linkButtons, loopbackWarning } from "../components/link.js";
import { contentOf, request, requestBlob, requestJson } from "../core/api.js";
import { el, notice } from "../core/dom.js";
import { say, sayError } from "../text/catalogue.js";
import { actionsFor } from "./words.js";

/** @typedef {import("./words.js").ParticipantRow} ParticipantRow */
/** @typedef {ReturnType<typeof actionsFor>[number]} Action */
/** @typedef {(action: string, body: Record<string, unknown>) => Promise<unknown>} Do */

/** @param {string} title @param {...(Node | null)} parts */
function openDialog(title, ...parts) {
  const dialog = el("dialog", { class: "card card-roomy dialog", "aria-labelledby": "dialog-title" });
  const close = el(
    "button",
    { type: "button", class: "button", onclick: () => dialog.close() },
    say("dashboard.close"),
  );
  dialog.append(
    el(
      "div",
      { class: "stack" },
      el("h2", { id: "dialog-title" }, title),
      ...parts.filter((part) => part !== null),
      el("div", { class: "row" }, close),
    ),
  );
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}

/** @param {unknown} error */
function sentence(error) {
  return notice("bad", sayError(error));
}

/** What can be done for one participant. @param {ParticipantRow} row @param {Do} act */
export function askForAction(row, act) {
  const body = el("div", { class: "stack" });
  const dialog = openDialog(row.pid, body);
  const choose = (/** @type {Action} */ action) => {
    if (action.holds) void hold(row, dialog, act, body);
    if (action.asks) body.replaceChildren(reasonForm(row, action, act, () => dialog.close()));
    else void run(row, action, "", act, body, () => dialog.close());
  };
  const buttons = actionsFor(row).map((action) =>
    el(
      "button",
      {
        type: "button",
        class: action.danger ? "button button-wide button-danger" : "button button-wide",
        onclick: () => choose(action),
      },
      action.label,
    ),
  );
  body.replaceChildren(...buttons);
}

/**
 * The round stands still while the reason is typed, so that it does not end first; afterwards it goes on, unless
 * somebody has paused it or another dialog holds it.
 * @param {ParticipantRow} row @param {HTMLDialogElement} dialog @param {Do} act @param {HTMLElement} problem
 */
async function hold({ pid }, dialog, act, problem) {
  const about = { pid, hold: `${Date.now()}-${Math.random()}` };
  // where that fails, the unit has ended, or its row shows the pause, and has a button that ends it
  const goOn = () => act("resume", about).catch(() => {});
  const closed = new Promise((done) => dialog.addEventListener("close", done));
  window.addEventListener("pagehide", goOn, { once: true }); // also while the pause is on its way
  await act("pause", about).catch((error) => dialog.open && problem.prepend(sentence(error)));
  await closed;
  window.removeEventListener("pagehide", goOn);
  await goOn();
}

/** @param {ParticipantRow} row @param {Action} action @param {Do} act @param {() => void} done */
function reasonForm(row, action, act, done) {
  const area = el("textarea", { id: "reason", class: "input note-input", rows: 3, maxlength: 4000, required: true });
  const problem = el("div", { role: "alert" });
  const submit = el(
    "button",
    { type: "submit", class: action.danger ? "button button-danger" : "button button-primary" },
    action.label,
  );
  const form = el(
    "form",
    { class: "stack", novalidate: true },
    el("div", { class: "field" }, el("label", { for: "reason" }, action.asks), area),
    problem,
    el("div", { class: "row" }, submit),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    if (area.value.trim()) return void run(row, action, area.value.trim(), act, problem, done);
    problem.replaceChildren(notice("bad", say("experimenter.reason.missing")));
    area.focus();
  });
  setTimeout(() => area.focus());
  return form;
}

/**
 * @param {ParticipantRow} row
 * @param {Action} action
 * @param {string} reason
 * @param {Do} act
 * @param {HTMLElement} problem
 * @param {() => void} done
 */
async function run({ pid, unit, last_round: last }, { action }, reason, act, problem, done) {
  try {
    await act(action, { pid, unit, episode: last?.episode, reason, text: reason });
    done();
  } catch (error) {
    problem.prepend(sentence(error));
  }
}

/** The link and code for whoever comes next. @param {string} token @param {Do} act */
export async function openNext(token, act) {
  const box = el("div", { class: "stack", role: "status" }, el("p", {}, say("experimenter.moment")));
  openDialog(say("experimenter.next"), box);
  try {
    const { code, path } = /** @type {{code: string, path: string}} */ (await act("open-next", {}));
    const address = new URL(path, location.href).href;
    const drawn = request(`/api/experimenter/qr.svg?code=${encodeURIComponent(code)}`, { token });
    const picture = `data:image/svg+xml,${encodeURIComponent(await contentOf(drawn, "text"))}`;
    box.replaceChildren(
      el("img", { class: "qr", src: picture, alt: say("experimenter.qr"), width: 200, height: 200 }),
      el("p", { class: "next-code" }, code),
      el("a", { class: "next-link", href: address, target: "_blank", rel: "noopener" }, address),
      linkButtons(address, document.title),
      el("p", { class: "muted small" }, say("experimenter.next.help")),
      ...[loopbackWarning(address, SERVE_EVERYWHERE)].filter((part) => part !== null),
    );
  } catch (error) {
    box.replaceChildren(sentence(error));
  }
}

/** Downloads what everybody is to be paid. @param {string} token @param {HTMLElement} said */
export async function downloadPayments(token, said) {
  try {
    const address = URL.createObjectURL(await requestBlob("/api/experimenter/payments.csv", { token }));
    el("a", { href: address, download: "payments.csv" }).click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
    said.textContent = say("experimenter.saved");
  } catch (error) {
    said.textContent = sayError(error);
  }
}

/** @param {string} token @returns {Do} */
export function actor(token) {
  return (action, body) => requestJson(`/api/experimenter/${action}`, { token, body, keepalive: action === "resume" });
}
