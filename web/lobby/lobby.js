// @ts-check
/*
 * The lobby: learn, play at once, or choose a map, who sits where and the time limit; make the room; go to it. What a
 * choice means is in choice.js, the pictures are the game's own renderer.
 */

import { ApiError, requestJson } from "../core/api.js";
import { say, sayError } from "../text/catalogue.js";
import { LANGUAGES, keepLanguage } from "../text/language.js";
import { colourName, mapDescription, mapTitle } from "../text/names.js";
import { prepareTexts } from "../text/page.js";
import { readLayout } from "../input/keyboard_layout.js";
import { controlsCard } from "./controls.js";
import { namedBadge } from "../components/named_badge.js";
import { badge, byId, el, notice } from "../core/dom.js";
import { LIMITS, defaultPartner, isOpen, parseSeed } from "./choice.js";
import { limitText, modeKey, roomRequest, seatOptions, seatsNote } from "./choice.js";
import { cardOf, extraMap, queryFor, takeListed, wantedName, wantedSeed } from "./extra_map.js";
import { mapGroups } from "./map_cards.js";
import { drawFirstPictures, firstChoice, firstRequest, showFirstGame } from "./newcomer.js";
import { researchLine } from "./partners.js";
import { mapPicture } from "../view/render.js";
import { openRoom } from "../wire/open_room.js";
import { wantedMap } from "../wire/played_map.js";
import { showShare } from "../components/share.js";

/** @typedef {import("../view/render.js").GameMap} GameMap */
/** @typedef {import("./choice.js").AgentCard} AgentCard */
/** @typedef {import("./choice.js").Choice} Choice */

const MEMORY = "movingout.lobby"; // localStorage: the last choice, without the seed
const RETRY_MS = 3000;

const form = byId("lobby", HTMLFormElement);
const mapsBox = byId("maps", HTMLElement);
const seatsBox = byId("seats", HTMLElement);
const chosenBox = byId("chosen", HTMLElement);
const PROBLEMS = ["first-problem", "problem", "practice-problem"]; // each beside its buttons
const problemBox = byId("problem", HTMLElement);
const limitSelect = byId("limit", HTMLSelectElement);
const randomisedBox = byId("randomised", HTMLInputElement);
const seedInput = byId("seed", HTMLInputElement);
const playButton = byId("play", HTMLButtonElement);
const playAllButton = byId("play-all", HTMLButtonElement);
const practiceButton = byId("practice", HTMLButtonElement);
const nowButton = byId("play-now", HTMLButtonElement);
const learnButton = byId("learn", HTMLButtonElement);
const surpriseButton = byId("surprise", HTMLButtonElement);
const PATIENCE_MS = 400; // before a page says that it is busy
const BUTTONS = [learnButton, nowButton, playButton, surpriseButton, playAllButton, practiceButton];

/** @type {GameMap[]} */
let maps = [];
/** @type {string[]} names of generated maps */
let surprises = [];
/** @type {import("./map_cards.js").OwnMaps} */
let own = { maps: [], leftOut: 0 };
/** @type {import("./extra_map.js").ExtraMap | null} */
let extra = null;
const prefersListed = takeListed();
/** @type {GameMap | null} */
let practiceMap = null;
/** @type {AgentCard[]} */
let agents = [];
let partner = "link";

/** Maps and agents. A refusal is shown once the answer is awaited, not before. */
function askLists() {
  const lists = Promise.all([requestJson("/api/maps"), requestJson("/api/agents")]);
  lists.catch(() => {});
  return lists;
}

/** @param {ReturnType<typeof askLists>} lists */
async function load(lists) {
  mapsBox.setAttribute("aria-busy", "true");
  try {
    const [mapList, agentList] = await lists;
    maps = mapList.maps;
    surprises = mapList.surprise ?? [];
    own = { maps: mapList.own ?? [], leftOut: mapList.own_left_out ?? 0 };
    practiceMap = mapList.practice;
    agents = agentList.agents;
    partner = defaultPartner(agents, agentList.default);
    showChoices(remembered());
    await findExtra(); // making a generated map takes a while: meanwhile the others are there
    offerSeed();
    const { pathname, hash } = location;
    if (hash === "#partner") offerPartner();
    if (pathname !== "/practice" && hash !== "#play") return;
    history.replaceState(null, "", "/"); // coming back does not start another game
    await (pathname === "/practice" ? learn() : playNow());
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    mapsBox.replaceChildren(notice("bad", `${sayError(error)} ${say("lobby.retry")}`));
    window.setTimeout(() => void load(askLists()), RETRY_MS);
  } finally {
    mapsBox.removeAttribute("aria-busy");
  }
}

/** @param {Choice} choice */
function showChoices(choice) {
  mapsBox.replaceChildren(...mapGroups(maps, own, extra, choice.map));
  seatsBox.replaceChildren(
    seatField(0, choice.seats[0]),
    seatField(1, choice.seats[1]),
    el("p", { id: "seats-note", class: "field-help", role: "status" }),
  );
  limitSelect.replaceChildren(...LIMITS.map((ticks) => el("option", { value: ticks }, limitText(ticks))));
  limitSelect.value = String(choice.limitTicks);
  showFirstGame(maps);
  drawPictures();
  refresh();
  for (const button of BUTTONS) button.disabled = false;
}

/** The reader came to choose somebody else to play with. */
function offerPartner() {
  const select = byId("seat-1", HTMLSelectElement);
  select.scrollIntoView({ block: "center" });
  select.focus();
}

/** The items are to be shuffled as the address says. */
function offerSeed() {
  const seed = wantedSeed(extra);
  if (seed === null) return;
  seedInput.value = String(seed);
  randomisedBox.checked = true;
  byId("more", HTMLDetailsElement).open = true;
  refresh();
}

/** The map of a card, where there is one. @param {string | undefined} card */
function mapAt(card) {
  if (extra && cardOf(extra) === card) return extra.map;
  return [...maps, ...own.maps].find(({ name }) => name === card);
}

/** The map that the address asks for; if there is none of that name, the page says so and offers the others. */
async function findExtra() {
  const before = choice().map;
  try {
    extra = await extraMap({ shipped: [...maps, ...(practiceMap ? [practiceMap] : [])], own: own.maps });
  } catch (error) {
    byId("first-problem", HTMLElement).replaceChildren(notice("attention", sayError(error)));
  }
  if (!extra) return;
  const now = choice();
  const isChosen = now.map !== before || (prefersListed && before === extra.map.name);
  showChoices({ ...now, map: isChosen ? now.map : cardOf(extra) });
}

function drawPictures() {
  drawFirstPictures(maps, practiceMap);
  for (const canvas of mapsBox.querySelectorAll("canvas")) {
    const map = mapAt(canvas.dataset.map);
    if (map) mapPicture(canvas, map);
  }
}

/** @param {number} seat @param {string} selected */
function seatField(seat, selected) {
  const options = seatOptions(agents);
  const select = el("select", { id: `seat-${seat}`, class: "select", "aria-describedby": `seat-help-${seat}` });
  for (const group of new Set(options.map((option) => option.group))) {
    const members = options.filter((option) => option.group === group);
    select.append(
      el("optgroup", { label: group }, ...members.map(({ value, label }) => el("option", { value }, label))),
    );
  }
  select.value = options.some(({ value }) => value === selected) ? selected : partner;
  return el(
    "div",
    { class: "field seat" },
    el("label", { for: `seat-${seat}` }, badge(seat), colourName(seat)),
    select,
    el("p", { id: `seat-help-${seat}`, class: "field-help" }),
  );
}

/** @returns {Choice} */
function choice() {
  const chosen = mapsBox.querySelector("input:checked");
  return {
    map: chosen instanceof HTMLInputElement ? chosen.value : maps[0].name,
    seats: [byId("seat-0", HTMLSelectElement).value, byId("seat-1", HTMLSelectElement).value],
    limitTicks: Number(limitSelect.value),
    seed: randomisedBox.checked ? parseSeed(seedInput.value) : null,
  };
}

/** @param {Choice} chosen @returns {Choice} with the name of its map, not the card */
function byName(chosen) {
  return { ...chosen, map: mapAt(chosen.map)?.name ?? chosen.map };
}

/** Brings every text that follows from the choice up to date. */
function refresh() {
  const { map: card, seats } = choice();
  const map = mapAt(card) ?? maps[0];
  chosenBox.replaceChildren(
    el(
      "div",
      { class: "row row-apart" },
      el("h2", {}, mapTitle(map)),
      el("span", { class: "pill" }, say(modeKey(map.mode))),
    ),
    el("p", {}, mapDescription(map)),
  );
  for (const seat of [0, 1]) {
    const option = seatOptions(agents).find(({ value }) => value === seats[seat]);
    byId(`seat-help-${seat}`, HTMLElement).textContent = option?.help ?? "";
  }
  showResearch(seats);
  byId("seats-note", HTMLElement).textContent = seatsNote(seats, matchMedia("(pointer: coarse)").matches);
  byId("hint", HTMLElement).hidden = seats.some(isOpen);
  const verb = seats.includes("here") ? "play" : seats.some(isOpen) ? "open" : "watch";
  playButton.textContent = say(`lobby.${verb}`, { map: mapTitle(map) });
  playAllButton.textContent = say(`lobby.${verb}All`, { number: maps.length });
  surpriseButton.textContent = say(`lobby.${verb}Surprise`);
  surpriseButton.hidden = surprises.length === 0;
  byId("seed-field", HTMLElement).hidden = !randomisedBox.checked;
}

/** What researchers want to know of the chosen agents. @param {readonly string[]} seats */
function showResearch(seats) {
  const lines = seats.flatMap((value, seat) => {
    const agent = agents.find(({ id }) => value === `agent:${id}`);
    const line = agent ? researchLine(agent) : "";
    return line ? [el("li", {}, namedBadge(seat), el("span", {}, line))] : [];
  });
  byId("research", HTMLElement).replaceChildren(...lines);
}

/** @returns {Choice} the address's map (?map=) and the last visit's choice, else a first visitor's */
function remembered() {
  const wanted = wantedName();
  const kept = lastChoice(firstChoice(maps, partner));
  return mapAt(wanted) ? { ...kept, map: wanted } : kept;
}

/** @param {Choice} first @returns {Choice} */
function lastChoice(first) {
  try {
    const kept = JSON.parse(localStorage.getItem(MEMORY) ?? "{}");
    return {
      ...first,
      ...(mapAt(kept.map) && { map: kept.map }),
      ...(Array.isArray(kept.seats) && kept.seats.length === 2 && { seats: kept.seats }),
      ...(LIMITS.some((ticks) => ticks === kept.limitTicks) && { limitTicks: kept.limitTicks }),
    };
  } catch {
    return first; // no storage, or not ours
  }
}

/** @param {Choice} chosen its map by name: the next visit may not have its card */
function remember({ map, seats, limitTicks }) {
  try {
    localStorage.setItem(MEMORY, JSON.stringify({ map, seats, limitTicks }));
  } catch {
    // next time starts from the defaults
  }
}

/** @param {string[]} cards of the rounds, or names of generated maps */
async function play(cards) {
  problemBox.replaceChildren(); // here and not on a change: the button must not move under the finger
  const chosen = choice();
  if (randomisedBox.checked && chosen.seed === null) {
    problemBox.replaceChildren(notice("bad", say("lobby.seed.wrong")));
    byId("more", HTMLDetailsElement).open = true;
    return seedInput.focus();
  }
  remember(byName(chosen));
  const names = cards.map((card) => mapAt(card)?.name ?? card);
  const request = roomRequest(chosen, names, false, partner);
  const drawn =
    extra && cards[0] === cardOf(extra) ? wantedMap(extra.map, extra.map.name, { shipped: [], own: [] }) : null;
  await enter({ ...request, ...(drawn?.map && drawn) }, chosen.seats, problemBox);
}

async function practise() {
  if (!practiceMap) return;
  const seats = /** @type {[string, string]} */ (["here", "agent:idle"]); // nobody hurries whoever learns
  const request = roomRequest({ ...choice(), seats }, [practiceMap.name], true);
  await enter(request, seats, byId("practice-problem", HTMLElement));
}

async function learn() {
  await enter({ tutorial: true }, ["here"], byId("first-problem", HTMLElement));
}

async function playNow() {
  await enter(firstRequest(maps, partner), ["here", partner], byId("first-problem", HTMLElement));
}

/**
 * Opens a room and goes there.
 * @param {ReturnType<typeof roomRequest> | {tutorial: true}} body @param {readonly string[]} seats
 * @param {HTMLElement} problems where a refusal is shown
 */
async function enter(body, seats, problems) {
  setBusy(true); // until the next page is there: a second press would open a second room
  for (const id of PROBLEMS) byId(id, HTMLElement).replaceChildren();
  const waiting = setTimeout(() => problems.replaceChildren(notice("", say("lobby.opening"))), PATIENCE_MS);
  try {
    const room = await openRoom(body);
    if (seats.includes("here")) return location.assign(room.join_path);
    if (!seats.some(isOpen)) return location.assign(room.watch_path);
    problems.replaceChildren();
    showShare(byId("share", HTMLElement), byId("choose", HTMLElement), room, seats);
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    problems.replaceChildren(notice("bad", sayError(error)));
    problems.scrollIntoView({ block: "nearest" });
  } finally {
    clearTimeout(waiting);
  }
  setBusy(false);
}

/** @param {boolean} busy */
function setBusy(busy) {
  for (const button of BUTTONS) button.disabled = busy;
}

function newSeed() {
  seedInput.value = String(Math.floor(Math.random() * 1_000_000));
}

/** The languages to choose from; another one takes effect on a reload, with the choices of the game kept. */
function showLanguages() {
  const select = byId("language", HTMLSelectElement);
  select.replaceChildren(...Object.entries(LANGUAGES).map(([code, name]) => el("option", { value: code }, name)));
  select.value = document.documentElement.lang;
  select.addEventListener("change", () => {
    keepLanguage(select.value);
    if (maps.length === 0) return location.assign(location.pathname + queryFor(null, prefersListed));
    const chosen = byName(choice());
    remember(chosen);
    const isOther = extra !== null && chosen.map === extra.map.name && choice().map !== cardOf(extra);
    location.assign(location.pathname + queryFor(chosen, isOther));
  });
}

const firstLists = askLists(); // on their way while the texts are
await Promise.all([prepareTexts(), readLayout()]);
showLanguages();
byId("controls", HTMLElement).append(controlsCard());
newSeed();
form.addEventListener("change", refresh);
form.addEventListener("submit", (event) => {
  event.preventDefault();
  void play([choice().map]);
});
playAllButton.addEventListener("click", () => void play(maps.map(({ name }) => name)));
surpriseButton.addEventListener("click", () => void play([surprises[Math.floor(Math.random() * surprises.length)]]));
practiceButton.addEventListener("click", () => void practise());
learnButton.addEventListener("click", () => void learn());
nowButton.addEventListener("click", () => void playNow());
byId("new-seed", HTMLButtonElement).addEventListener("click", newSeed);
new ResizeObserver(drawPictures).observe(mapsBox);
new IntersectionObserver(([{ isIntersecting }]) =>
  document.body.classList.toggle("first-in-view", isIntersecting),
).observe(byId("first", HTMLElement));
window.addEventListener("movingout-theme", drawPictures);
window.addEventListener("pageshow", (event) => {
  if (!event.persisted) return;
  for (const id of PROBLEMS) byId(id, HTMLElement).replaceChildren();
  setBusy(false); // back from the game
});
void load(firstLists);
