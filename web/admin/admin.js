// @ts-check
/*
 * The dashboard: process health and rooms, brought up to date once a second without a reload. Cells change in
 * place, so that the keyboard stays where it is. What the numbers are called is in admin_words.js.
 */

import { openWithToken } from "../core/admin_token.js";
import { facts, linkPill, phaseWords, recordingPill, seatWords, summaryWords, timeWords } from "./words.js";
import { ApiError, requestJson } from "../core/api.js";
import { badge, byId, el, notice } from "../core/dom.js";
import { mapTitle } from "../replay/recordings_filter.js";

/** @typedef {import("./words.js").AdminState} AdminState */
/** @typedef {import("./words.js").RoomRow} RoomRow */
/** @typedef {import("./words.js").Pill} Pill */
/** @typedef {{row: HTMLTableRowElement, cells: Map<string, HTMLElement>}} Shown */

const PATH = "/api/admin/state";
const EVERY_MS = 1000;
const COLUMNS = ["Room", "Where", "Seats", "Map", "Time", "Link", "Recording"];
const CLASSES = /** @type {Record<string, string>} */ ({ Room: "strong", Map: "nowrap", Time: "nowrap" });

const content = byId("content", HTMLElement);
/** @type {Map<string, Shown>} by room */
const shown = new Map();
let token = "";

async function load() {
  const opened = await openWithToken(byId("ask", HTMLElement), PATH);
  token = opened.token;
  content.hidden = false;
  show(opened.document);
  window.setInterval(() => void update(), EVERY_MS);
  document.addEventListener("visibilitychange", () => void update());
}

async function update() {
  if (document.hidden) return;
  try {
    show(await requestJson(PATH, { token, signal: AbortSignal.timeout(5 * EVERY_MS) }));
    setLost("");
  } catch (error) {
    setLost(error instanceof ApiError ? error.message : "The server takes long to answer.");
  }
}

/** Old figures stay, but look old. @param {string} reason empty: all is well */
function setLost(reason) {
  const box = byId("lost", HTMLElement);
  for (const part of content.querySelectorAll(".facts-row, .table-card")) part.classList.toggle("stale", reason !== "");
  if (box.textContent === "" && reason === "") return;
  box.replaceChildren(...(reason ? [notice("bad", reason, " These are the last figures; trying again…")] : []));
}

/** @param {AdminState} state */
function show(state) {
  byId("summary", HTMLElement).textContent = summaryWords(state);
  byId("refusal", HTMLElement).replaceChildren(
    ...(state.refusal ? [notice("attention", `No new games now: ${state.refusal}`)] : []),
  );
  showFacts(state);
  const present = new Set(state.rooms.map(({ room }) => room));
  for (const [room, { row }] of shown) {
    if (present.has(room)) continue;
    row.remove();
    shown.delete(room);
  }
  for (const room of state.rooms) showRoom(room);
  byId("empty", HTMLElement).hidden = state.rooms.length > 0;
}

/** @param {AdminState} state */
function showFacts(state) {
  byId("facts", HTMLElement).replaceChildren(
    ...facts(state).map(({ title, value, detail, tone }) =>
      el(
        "div",
        { class: "card fact", "data-tone": tone },
        el("dt", {}, title),
        el("dd", { class: "fact-value" }, value),
        el("dd", { class: "fact-detail" }, detail),
      ),
    ),
  );
}

/** @param {RoomRow} room */
function showRoom(room) {
  const known = shown.get(room.room) ?? addRoom(room);
  /** @type {Record<string, (Node | string)[]>} */
  const texts = {
    Room: [room.room],
    Where: [phaseWords(room), ...remark(room.reason || room.recording_problem)],
    Seats: [seats(room)],
    Map: [mapTitle(room.map), ...remark(room.phase === "lobby" ? "" : `${room.delivered} of ${room.items} delivered`)],
    Time: [timeWords(room)],
    Link: [pill(linkPill(room))],
    Recording: [pill(recordingPill(room))],
  };
  for (const [column, parts] of Object.entries(texts)) {
    const cell = known.cells.get(column);
    cell?.replaceChildren(...parts);
    cell?.toggleAttribute("data-empty", cell.textContent === "");
  }
}

/** @param {string} words */
function remark(words) {
  return words ? [el("span", { class: "room-remark" }, words)] : [];
}

/** @param {RoomRow} room @returns {Shown} */
function addRoom({ room }) {
  const cells = new Map(
    COLUMNS.map((column) => [column, el("td", { "data-label": column, class: CLASSES[column] ?? null })]),
  );
  const watch = el(
    "a",
    {
      class: "button button-small",
      href: `/watch/${encodeURIComponent(room)}`,
      target: "_blank",
      rel: "noopener",
      "aria-label": `Watch room ${room}`,
    },
    "Watch",
  );
  const close = el(
    "button",
    {
      type: "button",
      class: "button button-small",
      "aria-label": `Close room ${room}`,
      onclick: () => void closeRoom(room),
    },
    "Close",
  );
  const row = el("tr", { "data-room": room }, ...cells.values(), el("td", { class: "actions" }, watch, close));
  byId("rooms", HTMLElement).append(row);
  const entry = { row, cells };
  shown.set(room, entry);
  return entry;
}

/** @param {RoomRow} room */
function seats({ seats, spectators }) {
  const [blue, red] = seats.map((seat, index) => el("span", { class: "agent" }, badge(index), seatWords(seat)));
  const watching = spectators > 0 ? el("span", { class: "room-remark" }, `${spectators} watching`) : null;
  return el("span", { class: "room-seats" }, blue, red, watching);
}

/** @param {Pill} pill */
function pill({ words, tone }) {
  return words === "–"
    ? el("span", { class: "muted" }, words)
    : el("span", { class: `pill ${tone && `pill-${tone}`}` }, words);
}

/** @param {string} room */
async function closeRoom(room) {
  const dialog = byId("close-dialog", HTMLDialogElement);
  byId("close-text", HTMLElement).textContent = `The players of room ${room} are told so. What was recorded is kept.`;
  dialog.returnValue = "keep";
  dialog.showModal();
  await new Promise((done) => dialog.addEventListener("close", done, { once: true }));
  if (dialog.returnValue !== "close") return;
  try {
    await requestJson(`/api/admin/rooms/${encodeURIComponent(room)}/close`, { token, method: "POST" });
    await update();
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    setLost(error.message);
  }
}

void load();
