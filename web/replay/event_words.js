// @ts-check
/*
 * What happened in an episode, in words.
 */

import { clockText, secondsOf, ticksOf } from "../core/ticks.js";
import { has, say, sayNumber } from "../text/catalogue.js";
import { colourName } from "../text/names.js";

/** @typedef {import("./data.js").ReplayEvent} ReplayEvent */
/** @typedef {import("../view/render.js").GameMap} GameMap */

/**
 * Events that mean something to a participant have a text; the others are only in the journal.
 * @param {ReplayEvent} event
 */
function isShown({ kind }) {
  return has(`replay.event.${kind}`);
}

/** Problems that often come in a row: shown once, with their count. */
const REPEATED = new Set(["collision", "grab_failed", "deadline_missed", "agent_error", "tick_skipped"]);
const MERGE_TICKS = ticksOf(2);

/** @typedef {ReplayEvent & {times: number, last: number}} ShownEvent `last`: tick of the last of the merged events */

/**
 * The events worth showing, in order; repeated problems of the same kind and seat are merged. What happened in the tick
 * that was never finished, such as the loss that ended the round, stands at the end.
 * @param {readonly ReplayEvent[]} events
 * @param {number} ticks of the episode
 * @returns {ShownEvent[]}
 */
export function shownEvents(events, ticks) {
  /** @type {ShownEvent[]} */
  const shown = [];
  const ordered = events.filter(isShown).sort((a, b) => a.tick - b.tick);
  for (const event of ordered.map((one) => ({ ...one, tick: Math.min(one.tick, ticks) }))) {
    const run =
      REPEATED.has(event.kind) && shown.findLast(({ kind, seat }) => kind === event.kind && seat === event.seat);
    if (run && event.tick - run.last <= MERGE_TICKS) Object.assign(run, { times: run.times + 1, last: event.tick });
    else shown.push({ ...event, times: 1, last: event.tick });
  }
  return shown;
}

/** @param {ReplayEvent & {times?: number}} event @param {GameMap} map */
export function eventWords({ kind, seat, item, times = 1 }, map) {
  const who = seat < 0 ? say("replay.somebody") : colourName(seat);
  const told = kind === "ping" && item >= 0 ? "ping_item" : kind;
  const event = has(`replay.event.${told}`)
    ? say(`replay.event.${told}`, { who, what: itemName(map.items[item]) })
    : kind;
  return times > 1 ? say("replay.times", { event, times }) : event;
}

/** "large star". @param {{shape: string, size: string} | undefined} item */
export function itemName(item) {
  if (item === undefined) return say("replay.item.unknown");
  return say("replay.item", { size: say(`replay.size.${item.size}`), shape: say(`replay.shape.${item.shape}`) });
}

/** The tone of an event's mark on the time line: blue, red, ok or attention. @param {ReplayEvent} event */
export function eventTone({ kind, seat }) {
  if (kind === "delivered") return "ok";
  if (kind === "grab" || kind === "release" || kind === "ping") return seat === 0 ? "blue" : "red";
  return "attention";
}

/** The time of a tick to a tenth of a second: "0:12.3", in German "0:12,3". @param {number} tick */
export function tickTime(tick) {
  const tenths = Math.floor(10 * secondsOf(tick));
  const fraction = sayNumber((tenths % 10) / 10, 1).slice(1);
  return clockText(Math.floor(tenths / 10)) + fraction;
}
