// @ts-check
/*
 * What things are called that several pages show: colours, shapes, maps, agents, keys. What the catalogue does not
 * know, such as a map or an agent of one's own, keeps the name that the server gives it.
 */

import { currentLanguage, has, isolated, say } from "./catalogue.js";

const GENERATED = "generated"; // maps/generated/names.py: generated:awareness:12 or generated:awareness:12:hard
const DIFFICULTIES = ["easy", "medium", "hard"];
const COLOURS = ["blue", "red"];
const ROOM_PSEUDONYM = /^person-[\da-z]{6}$/; // server/rooms/seat_assignment.py
const STUDY_PSEUDONYM = /^P[\dA-Z]{6}$/; // study/store/identity.py

/** Titles that a study gives to maps of its own, by name. @type {Map<string, string>} */
const ownTitles = new Map();

/** @param {string} name of a map @param {string} title as a study has it in the reader's language */
export function nameMap(name, title) {
  ownTitles.set(name, title);
}

/** "Blue", for seat 0. @param {number} seat */
export function colourName(seat) {
  return say(`colour.${COLOURS[seat]}`);
}

/** "blue", within a sentence. @param {number} seat */
export function colourWord(seat) {
  return colourName(seat).toLocaleLowerCase(currentLanguage());
}

/** "square", as a label. @param {string} shape */
export function shapeName(shape) {
  return has(`editor.shape.${shape}`) ? say(`editor.shape.${shape}`) : say("shape.unknown");
}

/** "a square", as the object of a sentence. @param {string} shape */
export function shapeObject(shape) {
  return has(`shape.${shape}`) ? say(`shape.${shape}`) : say("shape.unknown");
}

/**
 * The title of a map; of an unknown one without a title its name, in words: "HandOff" -> "Hand Off". A map that is
 * mirrored or turned says so: "HandOff:mirror:rot90". A generated one is called after its seed, and says
 * its difficulty where its name does.
 * @param {{name: string, title?: string}} map
 */
export function mapTitle({ name, title: given }) {
  const [base, ...words] = name.split(":");
  if (base === GENERATED) return words.slice(2).reduce(changed, say("map.generated.title", { number: words[1] }));
  const title = has(`map.${base}.title`)
    ? say(`map.${base}.title`)
    : isolated(given ?? base.replace(/([a-z])([A-Z])/g, "$1 $2"));
  return words.reduce(changed, title);
}

/** @param {string} title @param {string} symmetry "mirror", "rot90", or the difficulty of a generated map */
function changed(title, symmetry) {
  const level = DIFFICULTIES.indexOf(symmetry) + 1;
  if (level > 0) return say("map.levelled", { title, level: say(`lobby.difficulty.${level}`) });
  if (symmetry === "mirror") return say("map.mirrored", { title });
  return say("map.turned", { title, degrees: Number(symmetry.replace("rot", "")) });
}

/** @param {{name: string, description: string}} map */
export function mapDescription({ name, description }) {
  const key = `map.${name.split(":")[0]}.description`;
  return has(key) ? say(key) : isolated(description);
}

/**
 * What people call an agent, by its id: "Computer partner" for "scripted:seed=3", "Trained partner (BASS)" for
 * "bass@all", "Own agent (Careful)" for "package.module:Careful". Any other name stays.
 * @param {string} id @param {string} [otherwise]
 */
export function agentName(id, otherwise = id) {
  const [name, ...options] = id.split(":");
  const [policy, population] = name.split("@");
  if (has(`agent.${name}`)) return say(`agent.${name}`);
  if (population !== undefined) return say("agent.trained", { policy: policyName(policy) });
  return /^[a-z_]\w*(\.\w+)+$/i.test(name) && options.length > 0 ? say("agent.own", { name: options[0] }) : otherwise;
}

/** "BASS" for "bass", "BASS, plain" for "bass-plain". @param {string} policy */
function policyName(policy) {
  const [base, ...variant] = policy.split("-");
  const name = has(`policy.${base}`) ? say(`policy.${base}`) : base;
  return [name, variant.join(" ")].filter(Boolean).join(", ");
}

/**
 * Whose recording one plays with: a pseudonym ("person-k3x9ab" of a room, "P7KXM2Q" of a study) tells a player nothing.
 * @param {string} name as it is recorded
 */
export function recordedPlayer(name) {
  return ROOM_PSEUDONYM.test(name) || STUDY_PSEUDONYM.test(name) ? say("play.otherPlayer") : agentName(name);
}

/**
 * A player on the page of one replay, which players open as well; the ids are in the file.
 * @param {string} kind @param {string} name as it is recorded
 */
export function replayedPlayer(kind, name) {
  return ROOM_PSEUDONYM.test(name) ? say("play.kind.human") : playerName(kind, name);
}

/**
 * A player for those who run a server or read recordings: agents with their ids beside the name.
 * @param {string} kind human, agent, remote, ghost or idle
 * @param {string} id of an agent; the name or pseudonym of somebody else, or empty
 */
export function playerName(kind, id) {
  const unnamed = has(`play.kind.${kind}`) ? say(`play.kind.${kind}`) : kind || "–";
  if (kind === "idle") return agentName(id || kind);
  const name = kind === "agent" ? agentName(id) : kind === "ghost" ? unnamed : id;
  return name === id || !id ? id || unnamed : `${name} · ${id}`;
}
