// @ts-check
/*
 * What happened in an episode, in words. Pure.
 */

/** @typedef {import("./replay_data.js").ReplayEvent} ReplayEvent */
/** @typedef {import("./render.js").GameMap} GameMap */

const SEATS = ["Blue", "Red"];

/** What a participant would call an event; the rest belongs to the journal. @type {Record<string, (who: string, what: string) => string>} */
const WORDS = {
  grab: (who, what) => `${who} takes the ${what}`,
  grab_failed: (who) => `${who} reaches for nothing`,
  release: (who, what) => `${who} lets the ${what} go`,
  delivered: (_, what) => `The ${what} is delivered`,
  undelivered: (_, what) => `The ${what} is out of the goal again`,
  pause: () => "Paused",
  resume: () => "Play goes on",
  drop: (who) => `${who} lost the connection`,
  return: (who) => `${who} is back`,
  deadline_missed: (who) => `${who} answered too late`,
  agent_error: (who) => `${who} had a fault`,
  tick_skipped: () => "A tick was skipped",
};

/** Whether an event is worth a line of its own. @param {ReplayEvent} event */
export function isTold({ kind }) {
  return kind in WORDS;
}

/** @param {ReplayEvent} event @param {GameMap} map */
export function eventWords({ kind, seat, item }, map) {
  const thing = map.items[item];
  return WORDS[kind]?.(SEATS[seat] ?? "Somebody", thing ? `${thing.size} ${thing.shape}` : "item") ?? kind;
}

/** How its mark on the time line looks: blue, red, ok or attention. @param {ReplayEvent} event */
export function eventTone({ kind, seat }) {
  if (kind === "delivered") return "ok";
  if (kind === "grab" || kind === "release") return seat === 0 ? "blue" : "red";
  return "attention";
}

/** "0:12.3". @param {number} tick of 100 ms */
export function tickTime(tick) {
  const seconds = Math.floor(tick / 10);
  return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}.${tick % 10}`;
}
