// @ts-check
/*
 * The dashboard of rooms and server health, updated once a second. Cells change in place, so that the keyboard focus
 * stays where it is. What the numbers are called is in words.js.
 */

import { openWithToken } from "../components/admin_token.js";
import { pill, remark, showFacts } from "../components/dashboard.js";
import {
  facts,
  linkPill,
  phaseWords,
  recordingPill,
  refusalWords,
  remarkWords,
  seatWords,
  summaryWords,
  timeWords,
} from "./words.js";
import { ApiError, requestJson } from "../core/api.js";
import { namedBadge } from "../components/named_badge.js";
import { byId, el, notice } from "../core/dom.js";
import { say, sayError } from "../text/catalogue.js";
import { mapTitle } from "../text/names.js";
import { prepareTexts } from "../text/page.js";

/** @typedef {import("./words.js").AdminState} AdminState */
/** @typedef {import("./words.js").RoomRow} RoomRow */
/** @typedef {{row: HTMLTableRowElement, cells: Map<string, HTMLElement>, rooms: number}} Shown rooms of its address */

const PATH = "/api/admin/state";
const EVERY_MS = 1000;
const COLUMNS = ["room", "phase", "seats", "map", "time", "link", "recording"];
const CLASSES = /** @type {Record<string, string>} */ ({ room: "strong", time: "nowrap" });

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
    show(await requestJson(PATH, { token, signal: AbortSignal.timeout?.(5 * EVERY_MS) }));
    setLost("");
  } catch (error) {
    setLost(error instanceof ApiError ? sayError(error) : say("dashboard.slowServer"));
  }
}

/** The last figures stay, but faded. @param {string} reason empty: all is well */
function setLost(reason) {
  const box = byId("lost", HTMLElement);
  for (const part of content.querySelectorAll(".facts-row, .table-card")) part.classList.toggle("stale", reason !== "");
  if (box.textContent === "" && reason === "") return;
  box.replaceChildren(...(reason ? [notice("bad", reason, ` ${say("dashboard.lastFigures")}`)] : []));
}

/** @param {AdminState} state */
function show(state) {
  byId("summary", HTMLElement).textContent = summaryWords(state);
  byId("refusal", HTMLElement).replaceChildren(...(state.refusal ? [notice("attention", refusalWords(state))] : []));
  showFacts(byId("facts", HTMLElement), facts(state));
  const present = new Set(state.rooms.map(({ room }) => room));
  for (const [room, { row }] of shown) {
    if (present.has(room)) continue;
    row.remove();
    shown.delete(room);
  }
  for (const room of state.rooms) showRoom(room);
  byId("empty", HTMLElement).hidden = state.rooms.length > 0;
}

/** @param {RoomRow} room */
function showRoom(room) {
  const known = shown.get(room.room) ?? addRoom(room);
  known.rooms = room.rooms_of_address;
  /** @type {Record<string, (Node | string)[]>} */
  const texts = {
    room: [room.room],
    phase: [phaseWords(room), ...remark(remarkWords(room))],
    seats: [seats(room)],
    map: [mapTitle({ name: room.map, title: room.title }), ...remark(delivered(room))],
    time: [timeWords(room)],
    link: [pill(linkPill(room))],
    recording: [pill(recordingPill(room))],
  };
  for (const [column, parts] of Object.entries(texts)) {
    const cell = known.cells.get(column);
    cell?.replaceChildren(...parts);
    cell?.toggleAttribute("data-empty", cell.textContent === "");
  }
}

/** @param {RoomRow} room */
function delivered({ phase, delivered, items }) {
  return phase === "lobby" ? "" : say("admin.delivered", { delivered, items });
}

/** @param {RoomRow} room @returns {Shown} */
function addRoom({ room }) {
  const cells = new Map(
    COLUMNS.map((column) => [
      column,
      el("td", { "data-label": say(`dashboard.column.${column}`), class: CLASSES[column] ?? null }),
    ]),
  );
  const watch = el(
    "a",
    {
      class: "button button-small",
      href: `/watch/${encodeURIComponent(room)}`,
      target: "_blank",
      rel: "noopener",
      "aria-label": say("admin.watchRoom", { room }),
    },
    say("dashboard.watch"),
  );
  const close = el(
    "button",
    {
      type: "button",
      class: "button button-small",
      "aria-label": say("admin.closeRoom", { room }),
      onclick: () => void closeRoom(room),
    },
    say("dashboard.close"),
  );
  const row = el("tr", { "data-room": room }, ...cells.values(), el("td", { class: "actions" }, watch, close));
  byId("rooms", HTMLElement).append(row);
  const entry = { row, cells, rooms: 0 };
  shown.set(room, entry);
  return entry;
}

/** @param {RoomRow} room */
function seats({ seats, spectators }) {
  const [blue, red] = seats.map((seat, index) => el("span", { class: "agent" }, namedBadge(index), seatWords(seat)));
  const watching =
    spectators > 0 ? el("span", { class: "room-remark" }, say("admin.watching", { count: spectators })) : null;
  return el("span", { class: "room-seats" }, blue, red, watching);
}

/** @param {string} room */
async function closeRoom(room) {
  const problem = byId("problem", HTMLElement);
  problem.replaceChildren();
  const dialog = byId("close-dialog", HTMLDialogElement);
  byId("close-text", HTMLElement).textContent = say("admin.closeRoom.text", { room });
  const rooms = shown.get(room)?.rooms ?? 0;
  const ofAddress = byId("close-address", HTMLButtonElement);
  ofAddress.hidden = rooms < 2;
  ofAddress.textContent = say("admin.close.address", { count: rooms });
  dialog.returnValue = "keep";
  dialog.showModal();
  await new Promise((done) => dialog.addEventListener("close", done, { once: true }));
  if (dialog.returnValue === "keep") return;
  try {
    await requestJson(`/api/admin/rooms/${encodeURIComponent(room)}/${dialog.returnValue}`, { token, method: "POST" });
    await update();
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    problem.replaceChildren(notice("bad", sayError(error)));
  }
}

await prepareTexts();
void load();
