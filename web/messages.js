// Generated from server/messages.py, server/frames.py, world/metrics.py, recordings/episode.py and
// study/questionnaire.py by `python -m movingout.server.messages_js`.
// Do not edit. The conversation is explained in docs/protocol.md.

export const SUBPROTOCOL = "movingout.v1";
export const PROTOCOL = 1;
export const TICK_MS = 100;
export const POSES_PER_TICK = 5;
export const LIMIT_TICKS = 500;
export const INVITED_S = 300.0;
export const PING_TICKS = 20;
export const REACH = 0.095;
export const REACH_TOLERANCE = 0.04;
export const CORNER_FRACTION = 0.01;
export const ARENA_HALF = 1.2;
export const ROBOT_RADIUS = 0.12;
export const WALL_MARGIN = 0.01;
export const BUNDLE = 1;
export const BEAT = 2;
export const INPUT = 3;
export const PING = 4;
export const PONG = 5;
export const POSITION_SCALE = 20000.0;
export const ANGLE_SCALE = 10430.378350470453;
export const AXIS_SCALE = 32767.0;
export const SLACK_SCALE = 10.0;
export const FLAG_NOT_RECORDING = 1;
export const FLAG_SKIPPED = 2;
export const CLOSE_RETRY = 4000;
export const CLOSE_RETRY_LATER = 4001;
export const CLOSE_KICKED = 4003;
export const CLOSE_REPLACED = 4004;
export const CLOSE_ROOM_OVER = 4005;
export const CLOSE_TOO_SLOW = 4008;
export const CLOSE_SHUTDOWN = 4010;
export const CLOSE_BAD_MESSAGE = 4400;
export const CLOSE_UNAUTHORISED = 4401;
export const CLOSE_NOT_FOUND = 4404;
export const DEVICES = Object.freeze(/** @type {const} */ (["keyboard","gamepad","touch","program"]));
export const EVENT = Object.freeze({"grab":0,"grab_failed":1,"release":2,"delivered":3,"undelivered":4,"deadline_missed":5,"agent_error":6});

/** @typedef {"likert7" | "tlx" | "choice" | "text"} QuestionKind */
export const LIKERT_MIN = 1;
export const LIKERT_MAX = 7;
export const TLX_MAX = 20;
export const NO_ANSWER = -1;
export const TEXT_LIMIT = 4000;

/** @typedef {"tcr" | "nfd" | "wt_s" | "ac" | "interdependence"} MetricKey */
/**
 * `low` and `high` bound the values, null where there is no bound; an `optional` metric may have no value.
 * @typedef {{
 *   key: MetricKey,
 *   symbol: string,
 *   unit: string,
 *   low: number | null,
 *   high: number | null,
 *   digits: number,
 *   optional: boolean
 * }} Metric
 */
export const NO_METRIC_VALUE = -1.0;
/** @type {readonly Metric[]} */
export const METRICS = Object.freeze([
  {"key":"tcr","symbol":"TCR","unit":"","low":0.0,"high":1.0,"digits":2,"optional":false},
  {"key":"nfd","symbol":"NFD","unit":"","low":null,"high":1.0,"digits":2,"optional":false},
  {"key":"wt_s","symbol":"WT","unit":"s","low":0.0,"high":null,"digits":1,"optional":false},
  {"key":"ac","symbol":"AC","unit":"","low":0.0,"high":1.0,"digits":2,"optional":true},
  {"key":"interdependence","symbol":"INT","unit":"","low":0.0,"high":1.0,"digits":2,"optional":true},
]);

export const FINISHED = Object.freeze(/** @type {const} */ (["delivered","time"]));

/**
 * Sent 50 ms after a bundle, so that TCP notices a lost packet sooner.
 * @typedef {object} Beat
 * @property {number} tick  of the bundle
 */

/** @param {Beat} frame @returns {ArrayBuffer} */
export function encodeBeat(frame) {
  const view = new DataView(new ArrayBuffer(5));
  view.setUint8(0, BEAT);
  view.setUint32(1, frame.tick, true);
  return view.buffer;
}

/** @param {ArrayBuffer} buffer @returns {Beat} */
export function decodeBeat(buffer) {
  const view = new DataView(buffer);
  if (view.byteLength !== 5 || view.getUint8(0) !== BEAT) throw new RangeError("not a Beat");
  return {
    tick: view.getUint32(1, true),
  };
}

/**
 * The state of one seat's controls.
 * @typedef {object} Input
 * @property {number} seat  0 blue, 1 red
 * @property {number} seq  counts the inputs of this seat; older ones are ignored
 * @property {number} ackTick  newest tick received: the acknowledgement
 * @property {number} seenTick  newest tick shown
 * @property {number} move  speed, from -1 (backward) to 1 (forward)
 * @property {number} heading  [rad], 0 is up, counter-clockwise
 * @property {number} grabs  presses of the grab button since `welcome`, modulo 256
 * @property {number} device  0: keyboard, 1: gamepad, 2: touch, 3: program
 * @property {number} clientMs  the client's clock [ms], only recorded
 */

/** @param {Input} frame @returns {ArrayBuffer} */
export function encodeInput(frame) {
  const view = new DataView(new ArrayBuffer(28));
  view.setUint8(0, INPUT);
  view.setUint8(1, frame.seat);
  view.setUint32(2, frame.seq, true);
  view.setUint32(6, frame.ackTick, true);
  view.setUint32(10, frame.seenTick, true);
  view.setInt16(14, Math.round(frame.move * AXIS_SCALE), true);
  view.setInt16(16, Math.round(frame.heading * ANGLE_SCALE), true);
  view.setUint8(18, frame.grabs);
  view.setUint8(19, frame.device);
  view.setFloat64(20, frame.clientMs, true);
  return view.buffer;
}

/** @param {ArrayBuffer} buffer @returns {Input} */
export function decodeInput(buffer) {
  const view = new DataView(buffer);
  if (view.byteLength !== 28 || view.getUint8(0) !== INPUT) throw new RangeError("not a Input");
  return {
    seat: view.getUint8(1),
    seq: view.getUint32(2, true),
    ackTick: view.getUint32(6, true),
    seenTick: view.getUint32(10, true),
    move: view.getInt16(14, true) / AXIS_SCALE,
    heading: view.getInt16(16, true) / ANGLE_SCALE,
    grabs: view.getUint8(18),
    device: view.getUint8(19),
    clientMs: view.getFloat64(20, true),
  };
}

/**
 * The client asks for a sample of the server's clock.
 * @typedef {object} Ping
 * @property {number} clientMs  the client's clock [ms]
 */

/** @param {Ping} frame @returns {ArrayBuffer} */
export function encodePing(frame) {
  const view = new DataView(new ArrayBuffer(9));
  view.setUint8(0, PING);
  view.setFloat64(1, frame.clientMs, true);
  return view.buffer;
}

/** @param {ArrayBuffer} buffer @returns {Ping} */
export function decodePing(buffer) {
  const view = new DataView(buffer);
  if (view.byteLength !== 9 || view.getUint8(0) !== PING) throw new RangeError("not a Ping");
  return {
    clientMs: view.getFloat64(1, true),
  };
}

/**
 * The answer to a ping.
 * @typedef {object} Pong
 * @property {number} clientMs  as in the ping
 * @property {number} serverMs  the server's clock [ms]
 */

/** @param {Pong} frame @returns {ArrayBuffer} */
export function encodePong(frame) {
  const view = new DataView(new ArrayBuffer(17));
  view.setUint8(0, PONG);
  view.setFloat64(1, frame.clientMs, true);
  view.setFloat64(9, frame.serverMs, true);
  return view.buffer;
}

/** @param {ArrayBuffer} buffer @returns {Pong} */
export function decodePong(buffer) {
  const view = new DataView(buffer);
  if (view.byteLength !== 17 || view.getUint8(0) !== PONG) throw new RangeError("not a Pong");
  return {
    clientMs: view.getFloat64(1, true),
    serverMs: view.getFloat64(9, true),
  };
}

/**
 * Something that happened inside a tick.
 * @typedef {object} BundleEvent
 * @property {number} code  what happened: a value of EVENT
 * @property {number} seat  -1 for none
 * @property {number} item  -1 for none
 * @property {number} pose  which pose of the tick (0-4) to show it with
 */

/**
 * One tick for the client to play back: five poses of every body, and what happened.
 * @typedef {object} Bundle
 * @property {number} flags  1: this tick is not recorded, 2: ticks were skipped before it
 * @property {number} epoch  number of the round, as in `round`, modulo 65536
 * @property {number} tick  number of the state after it, from 1 in each round
 * @property {number} timeMs  server time at which the tick starts [ms]
 * @property {[number, number]} seqs  newest input applied, 0 for none
 * @property {[number, number]} slackMs  how long before the tick that input came [ms]
 * @property {[number, number]} held  item in the hand, -1 for none
 * @property {boolean[]} delivered  one bit per item
 * @property {number} bodies  two robots, then the items
 * @property {number} poseCount  poses of each body
 * @property {Float64Array} poses  poseCount x bodies x (x, y, angle)
 * @property {BundleEvent[]} events
 */

/** @param {ArrayBuffer} buffer @returns {Bundle} */
export function decodeBundle(buffer) {
  const view = new DataView(buffer);
  if (view.byteLength < 37 || view.getUint8(0) !== BUNDLE) throw new RangeError("not a Bundle");
  const bodies = view.getUint8(34);
  const poseCount = view.getUint8(35);
  const eventCount = view.getUint8(36);
  const firstEvent = 37 + poseCount * bodies * 6;
  if (view.byteLength !== firstEvent + eventCount * 4) throw new RangeError("a cut Bundle");
  const poses = new Float64Array(poseCount * bodies * 3);
  for (let index = 0, at = 37; at < firstEvent; index += 3, at += 6) {
    poses[index + 0] = view.getInt16(at + 0, true) / POSITION_SCALE;
    poses[index + 1] = view.getInt16(at + 2, true) / POSITION_SCALE;
    poses[index + 2] = view.getInt16(at + 4, true) / ANGLE_SCALE;
  }
  const events = [];
  for (let at = firstEvent; at < view.byteLength; at += 4) {
    events.push({ code: view.getUint8(at + 0), seat: view.getInt8(at + 1), item: view.getInt8(at + 2), pose: view.getUint8(at + 3) });
  }
  return {
    flags: view.getUint8(1),
    epoch: view.getUint16(2, true),
    tick: view.getUint32(4, true),
    timeMs: view.getFloat64(8, true),
    seqs: [view.getUint32(16, true), view.getUint32(20, true)],
    slackMs: [view.getUint16(24, true) / SLACK_SCALE, view.getUint16(26, true) / SLACK_SCALE],
    held: [view.getInt8(28), view.getInt8(29)],
    delivered: flagsOf(view.getUint32(30, true), bodies - 2),
    bodies,
    poseCount,
    poses,
    events,
  };
}

/** Flag `i` is bit `i`. @param {number} bits @param {number} length @returns {boolean[]} */
function flagsOf(bits, length) {
  return Array.from({ length }, (_, index) => ((bits >>> index) & 1) === 1);
}

/** @typedef {"lobby" | "countdown" | "playing" | "paused" | "round_over" | "series_over" | "closed"} Phase */
/** @typedef {"play" | "watch"} Mode */
/** @typedef {"human" | "agent" | "remote" | "ghost" | "idle"} Kind */
/** @typedef {"drive" | "grab" | "deliver" | "backward" | "lift"} TutorialStep */

/**
 * One seat as everybody in the room may see it.
 * @typedef {{
 *   colour: string,
 *   kind: Kind,
 *   name: string,
 *   open: boolean,
 *   present: boolean,
 *   ready: boolean,
 *   device: string,
 *   rtt_ms: number,
 *   visible: boolean
 * }} SeatState
 */

/**
 * A seat of this client with its token: keep it for reloads; it changes at each join.
 * @typedef {{
 *   seat: number,
 *   token: string
 * }} SeatGrant
 */

/**
 * A binary frame, so that a program can read and write it by name.
 * @typedef {{
 *   format: string,
 *   names: string[]
 * }} FrameFields
 */

/**
 * The first message of every socket, within 5 s.
 * @typedef {{
 *   type: "join",
 *   room: string,
 *   mode?: Mode,
 *   tokens?: string[],
 *   claim?: number,
 *   name?: string,
 *   program?: boolean
 * }} Join
 */

/**
 * Whether the person in `seat` is ready for the coming round.
 * @typedef {{
 *   type: "ready",
 *   seat: number,
 *   ready?: boolean
 * }} Ready
 */

/**
 * Stop the clock (`resume` is the same button: ready again).
 * @typedef {{
 *   type: "pause",
 *   seat: number
 * }} Pause
 */

/**
 * The person in `seat` leaves for good: the episode ends cleanly.
 * @typedef {{
 *   type: "leave",
 *   seat: number
 * }} Leave
 */

/**
 * Play the last round's map once more (`Ready` goes on to the next one).
 * @typedef {{
 *   type: "again",
 *   seat: number
 * }} Again
 */

/**
 * Please send the whole state.
 * @typedef {{
 *   type: "keyframe"
 * }} Keyframe
 */

/**
 * The page is hidden, and its seats go neutral, or visible; sent after each welcome and change, and recorded.
 * @typedef {{
 *   type: "focus",
 *   visible: boolean
 * }} Focus
 */

/**
 * The person in `seat` ends the tutorial early; recorded.
 * @typedef {{
 *   type: "skip",
 *   seat: number
 * }} Skip
 */

/**
 * "Help here", from the person in `seat`: at an item, or at the own place (-1).
 * @typedef {{
 *   type: "ping",
 *   seat: number,
 *   item?: number
 * }} SayPing
 */

/**
 * The answer to `Join`.
 * @typedef {{
 *   type: "welcome",
 *   protocol: number,
 *   build: string,
 *   room: string,
 *   mode: Mode,
 *   seats: SeatGrant[],
 *   resume_s: number,
 *   join_path: string,
 *   watch_path: string,
 *   study: boolean,
 *   pings: boolean,
 *   frames: Record<string, FrameFields>
 * }} Welcome
 */

/**
 * The coming or running round: bodies are the two robots, then `map.items` in order.
 * @typedef {{
 *   type: "round",
 *   index: number,
 *   total: number,
 *   epoch: number,
 *   map: Record<string, any>,
 *   limit_ticks: number,
 *   practice: boolean,
 *   episode: string
 * }} Round
 */

/**
 * Phase and seats, on every change and once a second.
 * @typedef {{
 *   type: "room",
 *   phase: Phase,
 *   reason: string,
 *   until_ms: number,
 *   seats: SeatState[],
 *   spectators: number,
 *   recording: boolean,
 *   reason_code: string,
 *   reason_values: Record<string, any>
 * }} RoomState
 */

/**
 * The whole state after `tick` at server time `time_ms`.
 * @typedef {{
 *   type: "keyframe",
 *   epoch: number,
 *   tick: number,
 *   time_ms: number,
 *   poses: number[][],
 *   held: number[],
 *   delivered: boolean[]
 * }} FullState
 */

/**
 * Where a tutorial is: sent after `Round`, and whenever a step or a seat's part in it is done.
 * @typedef {{
 *   type: "tutorial",
 *   step: TutorialStep,
 *   number: number,
 *   total: number,
 *   finished: boolean,
 *   done: boolean[],
 *   rings: number[][],
 *   targets: number[]
 * }} Tutorial
 */

/**
 * How a round ended.
 * @typedef {{
 *   type: "result",
 *   index: number,
 *   outcome: string,
 *   ticks: number,
 *   delivered: number,
 *   items: number,
 *   tcr: number,
 *   nfd: number,
 *   wt_s: number,
 *   ac: number,
 *   recording: string,
 *   metrics: Record<string, number>,
 *   delivered_by: number[][]
 * }} Result
 */

/**
 * Something this client asked for cannot be done; the socket stays open.
 * @typedef {{
 *   type: "error",
 *   code: string,
 *   message: string,
 *   values: Record<string, any>
 * }} Problem
 */

/**
 * The last message before the server closes with `code`.
 * @typedef {{
 *   type: "bye",
 *   code: number,
 *   message: string,
 *   error: string,
 *   values: Record<string, any>
 * }} Bye
 */

/**
 * A seat asks for help: to be shown for `ticks` ticks.
 * @typedef {{
 *   type: "ping",
 *   epoch: number,
 *   tick: number,
 *   seat: number,
 *   item: number,
 *   x: number,
 *   y: number,
 *   ticks: number
 * }} ShownPing
 */

/** @typedef {Join | Ready | Pause | Leave | Again | Keyframe | Focus | Skip | SayPing} ClientMessage */

/** @typedef {Welcome | Round | RoomState | FullState | Tutorial | Result | Problem | Bye | ShownPing} ServerMessage */
