// @ts-check
/*
 * What happened in an episode, in words. Pure.
 */

import { clockText, secondsOf, ticksOf } from "../core/ticks.js";

/** @typedef {import("./data.js").ReplayEvent} ReplayEvent */
/** @typedef {import("../view/render.js").GameMap} GameMap */

const SEATS = ["Blue", "Red"];

/**
 * What a participant would call an event; the rest belongs to the journal.
 * @type {Record<string, (who: string, what: string) => string>}
 */
const WORDS = {
  grab: (who, what) => `${who} takes the ${what}`,
  grab_failed: (who) => `${who} reaches for nothing`,
  release: (who, what) => `${who} lets the ${what} go`,
  delivered: (_, what) => `The ${what} is delivered`,
  undelivered: (_, what) => `The ${what} is out of the goal again`,
  collision: () => "Blue and Red bump into each other",
  pause: () => "Paused",
  resume: () => "Play goes on",
  drop: (who) => `${who} lost the connection`,
  return: (who) => `${who} is back`,
  deadline_missed: (who) => `${who} answered too late`,
  agent_error: (who) => `${who} had a fault`,
  unseen_map: (who) => `${who} was not trained on this map`,
  tick_skipped: () => "A tick was skipped",
};

/** @param {ReplayEvent} event */
function isTold({ kind }) {
  return kind in WORDS;
}

/** Troubles that come many in a row: told once, with how often. */
const REPEATED = new Set(["collision", "grab_failed", "deadline_missed", "agent_error", "tick_skipped"]);
const SAME_TROUBLE_TICKS = ticksOf(2);

/** @typedef {ReplayEvent & {times: number, last: number}} ToldEvent `last`: tick of the last of them */

/**
 * The events worth telling, in order, with troubles of the same kind and seat drawn together.
 * @param {readonly ReplayEvent[]} events
 * @returns {ToldEvent[]}
 */
export function toldEvents(events) {
  /** @type {ToldEvent[]} */
  const told = [];
  for (const event of events.filter(isTold).sort((a, b) => a.tick - b.tick)) {
    const run =
      REPEATED.has(event.kind) && told.findLast(({ kind, seat }) => kind === event.kind && seat === event.seat);
    if (run && event.tick - run.last <= SAME_TROUBLE_TICKS)
      Object.assign(run, { times: run.times + 1, last: event.tick });
    else told.push({ ...event, times: 1, last: event.tick });
  }
  return told;
}

/** @param {ReplayEvent & {times?: number}} event @param {GameMap} map */
export function eventWords({ kind, seat, item, times = 1 }, map) {
  const thing = map.items[item];
  const words = WORDS[kind]?.(SEATS[seat] ?? "Somebody", thing ? `${thing.size} ${thing.shape}` : "item") ?? kind;
  return times > 1 ? `${words}, ${times} times` : words;
}

/** How its mark on the time line looks: blue, red, ok or attention. @param {ReplayEvent} event */
export function eventTone({ kind, seat }) {
  if (kind === "delivered") return "ok";
  if (kind === "grab" || kind === "release") return seat === 0 ? "blue" : "red";
  return "attention";
}

/** The time of a tick to a tenth of a second: "0:12.3". @param {number} tick */
export function tickTime(tick) {
  const tenths = Math.floor(10 * secondsOf(tick));
  return `${clockText(Math.floor(tenths / 10))}.${tenths % 10}`;
}
