// Every sentence of the play page, for people: short, plain, no jargon.

import {
  CLOSE_BAD_MESSAGE,
  CLOSE_KICKED,
  CLOSE_NOT_FOUND,
  CLOSE_REPLACED,
  CLOSE_ROOM_OVER,
  CLOSE_UNAUTHORISED,
} from "../messages.js";
import { studyMarkOf } from "./study_mark.js";
import { GERMAN } from "./text_de.js";

/** "a square", "an octagon". @param {string} shape */
const withArticle = (shape) => `${/^[aeiou]/.test(shape) ? "an" : "a"} ${shape}`;

export const ENGLISH = {
  reload: "This page does not match the server any more. Please reload it.",
  /** @type {Record<number, string>} why a socket was closed for good */
  closed: {
    [CLOSE_KICKED]: "You were taken out of this game.",
    [CLOSE_REPLACED]: "You went on in another window. This one can be closed.",
    [CLOSE_ROOM_OVER]: "This game is over.",
    [CLOSE_BAD_MESSAGE]: "This page does not match the server any more. Please reload it.",
    [CLOSE_UNAUTHORISED]: "This seat is not yours any more. You can watch, or start a new game.",
    [CLOSE_NOT_FOUND]: "There is no such game. It may be over, or the link is not complete.",
  },
  connecting: "Connecting…",
  reconnecting: "Connection lost. Trying again…",
  you: "You",
  partner: "Partner",
  colours: ["Blue", "Red"],
  devices: { keyboard: "keyboard", gamepad: "gamepad", touch: "touch", program: "program" },
  practice: "Practice",
  round: (/** @type {number} */ index, /** @type {number} */ total) =>
    total > 1 ? `Round ${index + 1} of ${total}` : "One round",
  timeLeft: "Time left",
  time: "Time",
  delivered: "Delivered",
  task: {
    both: "Carry everything into the green area. Items marked 2 need both of you.",
    some: "Carry everything into the green area. Items marked 1–2 are faster with two.",
    small: "Carry everything into the green area.",
    goals: (/** @type {string} */ sentence) => sentence.replace("the green area", "the green areas"),
  },
  state: {
    notHere: "not here yet",
    ready: "ready",
    notReady: "getting ready",
    gone: "reconnecting…",
    free: "hands free",
    carrying: (/** @type {string} */ shape) => `carrying ${withArticle(shape)}`,
    together: (/** @type {string} */ shape) => `carrying ${withArticle(shape)} together`,
    help: "waiting for your help",
    helpPartner: "waiting for help",
    slow: (/** @type {string} */ shape) => `carrying ${withArticle(shape)} alone, slowly`,
    idle: "does nothing",
    blocked: (/** @type {string} */ shape) => `holding ${withArticle(shape)}: too heavy for one`,
  },
  kinds: { human: "A person", agent: "Agent", remote: "Program", ghost: "Recording", idle: "Nobody" },
  controls: "Controls",
  change: "Change…",
  actions: {
    move: "move",
    grab: "grab / let go",
    backward: "drive backward",
  },
  stick: "left stick",
  shift: "Shift",
  touchMove: "left side",
  touchGrab: "Grab",
  touchBackward: "Backward",
  thoughts: {
    title: "What agents weigh",
    show: "Show candidates",
    hide: "Hide candidates",
    none: "No agent here says what it weighs.",
    score: (/** @type {string} */ letter, /** @type {number} */ score) => `${letter}  ${score.toFixed(3)}`,
    chosen: "played",
  },
  connection: "Connection",
  quality: {
    good: (/** @type {number} */ ms) => `good · ${ms} ms`,
    fair: (/** @type {number} */ ms) => `fair · ${ms} ms`,
    poor: (/** @type {number} */ ms) => `slow · ${ms} ms`,
    stalled: "stalled",
    lost: "lost",
    waiting: "…",
  },
  notRecording: "Not recorded",
  pauseOrStop: "Pause or stop…",
  leave: "Leave",
  stopWatching: "Stop watching",
  watching: "You are watching.",
  watchers: (/** @type {number} */ count) => (count === 1 ? "1 person is watching." : `${count} people are watching.`),
  waiting: {
    title: "Waiting for your partner",
    program: "Waiting for a program",
    sentence: "Send this link to the person who plays with you, or show them the code.",
    copy: "Copy link",
    copied: "Copied",
    qr: "QR code of the link",
    /** @type {(count: number) => string} */
    seats: (count) => (count === 1 ? "One seat is still free." : "Both seats are still free."),
  },
  ready: {
    title: "Ready?",
    soon: "The game begins when both are ready.",
    you: (/** @type {string} */ colour) => `You are ${colour.toLowerCase()}`,
    press: (/** @type {string} */ how) => `Press ${how} when you are ready.`,
    button: "I am ready",
    waitingFor: (/** @type {string} */ name) => `Waiting for ${name}.`,
    swap: "Swap sides",
    or: " or ",
  },
  pause: {
    title: "Paused",
    goOn: (/** @type {string} */ how) => `Press ${how} to go on.`,
    button: "Go on",
    stop: "Stop the game",
    sure: "Stop the game for both of you?",
    yes: "Yes, stop",
    no: "No, go on playing",
    back: (/** @type {number} */ seconds) => `${seconds} s left to come back`,
  },
  over: {
    title: "Thank you",
    sentence: "That was all. You can close this page.",
    watch: "Watch",
    lobby: "To the start page",
    reload: "Reload",
    questionsFor: (/** @type {string} */ colour) => `Questions for ${colour.toLowerCase()}`,
  },
  settings: {
    title: "Keys and buttons",
    intro: "Choose a key or button, then press the new one. Kept in this browser.",
    sets: ["First keys", "Second keys"],
    gamepad: "Gamepad",
    press: "press a key",
    pressButton: "press a button",
    deadZone: "Stick dead zone",
    wide: "0.3 (usual)",
    narrow: "0.15",
    actions: {
      up: "up",
      left: "left",
      down: "down",
      right: "right",
      grab: "grab",
      backward: "backward",
      pause: "pause",
    },
    reset: "Back to the defaults",
    done: "Done",
  },
  arena: (/** @type {string} */ map, /** @type {number} */ done, /** @type {number} */ all) =>
    `The room “${map}”. ${done} of ${all} items delivered.`,
  announce: {
    delivered: (/** @type {number} */ done, /** @type {number} */ all) => `${done} of ${all} delivered.`,
    start: "Go.",
    paused: (/** @type {string} */ reason) => `Paused. ${reason}`,
    stalled: "Connection stalled.",
    halfTime: "Half of the time is over.",
    tenSeconds: "Ten seconds left.",
  },
};

/** A round of a study speaks the language of the study; everything else is English. */
function chosen() {
  if (typeof location === "undefined") return ENGLISH; // no page: a test
  return studyMarkOf(location.pathname.split("/")[2] ?? "")?.language === "de" ? GERMAN : ENGLISH;
}

export const TEXT = chosen();
