// The game page: connects socket, devices, model and views, and runs them once per displayed frame.

import { Announcer } from "./announcer.js";
import { Arena } from "./arena/arena.js";
import { Pings } from "./arena/pings.js";
import { Connection } from "../wire/connection.js";
import { answerOtherTabs, askOtherTabs } from "../wire/other_tabs.js";
import { loadTokens, saveTokens } from "../wire/seat_tokens.js";
import { lastingStorage } from "../core/browser_storage.js";
import { byId } from "../core/dom.js";
import { Game } from "./game.js";
import { Hud, touchControls } from "./hud.js";
import { Gamepads } from "../input/gamepad.js";
import { Keyboard } from "../input/keyboard.js";
import { readLayout } from "../input/keyboard_layout.js";
import { loadMapping } from "../input/mapping.js";
import { LostPads } from "../input/lost_pads.js";
import { PadMemory, STUDY_PADS } from "../input/pad_memory.js";
import { LocalSeats } from "../input/seats.js";
import { InputSenders } from "../input/sender.js";
import { Touch } from "../input/touch.js";
import { Panels } from "./panels.js";
import { PauseControl } from "./pause_control.js";
import { Probe } from "./probe.js";
import { AfterRound } from "./after_round.js";
import { Settings } from "./settings.js";
import { TabTitle } from "./tab_title.js";
import { StudyGame } from "../study/game.js";
import { studyMarkOf } from "../text/study_mark.js";
import { lostText, refusalText } from "./seat_phrases.js";
import { say } from "../text/catalogue.js";
import { prepareTexts } from "../text/page.js";
import { nameMap } from "../text/names.js";
import { Cues } from "./signals/cues.js";
import { Sounds } from "./signals/sounds.js";
import { TutorialView } from "./tutorial.js";
import { DecisionPanel } from "./decision_trace.js";

/** @typedef {import("../wire/connection.js").Status} Status */

const [, page, room] = location.pathname.split("/");
const mode = page === "watch" ? "watch" : "play";
const studyMark = mode === "play" ? studyMarkOf(room) : null;
const HUD_MS = 90; // texts and bars do not need 60 Hz
const DEAF_MS = 800; // the last presses before a pause or the end must not skip it
const SENT_MS = 150; // until a message has left before the page does
const coarse = matchMedia("(pointer: coarse)");

class Play {
  #root = byId("play", HTMLElement);
  #game = new Game();
  #probe = new Probe(this.#game);
  #hud = new Hud();
  #cues = new Cues(this.#game);
  #sounds = new Sounds(studyMark === null || studyMark.sounds === true);
  #announcer = new Announcer();
  #connection = new Connection(room, mode, this);
  #gamepads = new Gamepads(() => navigator.getGamepads?.() ?? []);
  #settings = new Settings(loadMapping(lastingStorage()), this.#gamepads, () => this.#panels.focusAction());
  #keyboard = new Keyboard(
    window,
    () => this.#mapping.keys,
    () => this.#readDevices(performance.now()),
  );
  #touch = new Touch(touchControls(), () => this.#readDevices(performance.now()));
  #seats = new LocalSeats(
    { keyboard: this.#keyboard, gamepads: this.#gamepads, touch: this.#touch },
    coarse.matches ? "touch" : "keyboard",
    studyMark ? new PadMemory(STUDY_PADS, studyMark.people) : new PadMemory(room),
  );
  #study = studyMark && new StudyGame(studyMark);
  #panels = new Panels({
    ready: (seat) => this.#ready(seat),
    stop: () => this.#leave(),
    askStop: this.#study ? () => void this.#study?.askToStop().then(() => this.#panels.focusAction()) : null,
    asksReady: this.#study === null,
  });
  #afterRound =
    this.#study ??
    new AfterRound({
      next: () => this.#each((seat) => this.#ready(seat)),
      again: () => this.#each((seat) => this.#connection.send({ type: "again", seat })),
    });
  #pings = new Pings(
    this.#game,
    {
      send: (message) => this.#connection.send(message),
      announce: (sentence) => this.#announcer.announce(sentence),
    },
    { box: byId("arena-box", HTMLElement), button: byId("touch-ping", HTMLButtonElement) },
  );
  #tutorial = new TutorialView(
    {
      skip: () => this.#skip(),
      again: () => this.#each((seat) => this.#connection.send({ type: "again", seat })),
    },
    this.#study !== null,
  );
  #tab = new TabTitle();
  #decisions = new DecisionPanel(byId("decisions", HTMLElement), `/api/rooms/${room}`);
  #arena = new Arena(this.#game, { cues: this.#cues, pings: this.#pings, decisions: this.#decisions });
  #inputs = new InputSenders(
    (input) => this.#connection.sendInput(input),
    () => ({
      ackTick: this.#game.newestTick,
      seenTick: this.#probe.tick,
    }),
  );
  /** @type {(import("../view/render.js").Intent | null)[]} */
  #intents = [null, null];
  /** @type {Status} */
  #status = "connecting";
  #lossText = ""; // what the server said before it closed
  #statusSinceMs = 0;
  #phase = "";
  #phaseSinceMs = 0;
  #hudAtMs = 0;
  #lostPads = new LostPads();
  #pauses = new PauseControl({
    game: this.#game,
    panels: this.#panels,
    pause: (seat) => this.#connection.send({ type: "pause", seat }),
    ready: (seat) => this.#ready(seat),
    dialogIsOpen: () => this.#dialogIsOpen,
  });

  start() {
    const stop = byId("stop", HTMLButtonElement);
    stop.addEventListener("click", () => (mode === "watch" ? location.assign("/") : this.#pauses.pauseOrStop()));
    stop.disabled = false;
    addEventListener("keydown", (event) => this.#pauses.key(event));
    addEventListener("pointerdown", (event) => event.pointerType === "touch" && this.#touch.wake());
    addEventListener("blur", () => this.#letGo());
    document.addEventListener("visibilitychange", () => this.#visibility());
    Object.assign(this.#probe, { cues: this.#cues, sounds: this.#sounds });
    this.#root.toggleAttribute("data-touch", mode === "play" && coarse.matches); // so that nothing moves later
    this.#root.toggleAttribute("data-watch", mode === "watch");
    this.#connection.open();
    // A study has its own word for who opens it again.
    if (mode === "play" && !this.#study)
      answerOtherTabs(room, () => (this.#status === "open" && this.#game.own.length > 0 ? loadTokens(room) : []));
    this.#probe.pings = () => this.#pings.shown;
    if (mode === "watch") void this.#decisions.offerWhenWeighing();
    requestAnimationFrame((now) => this.#frame(now));
  }

  get #mapping() {
    return this.#settings.mapping;
  }

  get #dialogIsOpen() {
    return this.#settings.isOpen || this.#study?.isAsking === true;
  }

  /** What follows a round: a tutorial of the lobby has an end of its own. */
  get #after() {
    return this.#game.tutorial !== null && this.#study === null ? this.#tutorial : this.#afterRound;
  }

  /** Whether a result stands in place of the arena; the end of a tutorial, or in a study, lies over it. */
  get #arenaIsGone() {
    return this.#study === null && this.#after === this.#afterRound && this.#afterRound.showsResult;
  }

  // ---- from the connection ----------------------------------------------------------------------------------

  /** @param {import("../messages.js").ServerMessage} message @param {number} atMs */
  onMessage(message, atMs) {
    this.#game.receive(message, atMs);
    if (message.type === "error") {
      this.#hud.showProblem(refusalText(message), atMs);
      if (message.code === "pauses_used") this.#pauses.refused();
    }
    if (message.type === "ping") this.#pings.receive(message, atMs);
    this.#tab.receive(message);
    if (message.type !== "welcome") return;
    this.#connection.send({ type: "focus", visible: !document.hidden });
    this.#seats.hold(this.#game.own);
    this.#inputs.hold(this.#game.own);
    this.#settings.offersPings = this.#pings.possible;
    this.#root.toggleAttribute("data-watch", message.mode === "watch");
  }

  /** @param {import("../messages.js").Bundle} bundle @param {number} atMs */
  onBundle(bundle, atMs) {
    this.#game.addBundle(bundle, atMs);
    // A hidden tab draws no frames, but the server still needs to know that the page keeps up.
    if (document.hidden) this.#inputs.sendNeutral(atMs);
  }

  /** @param {number} sentMs @param {number} serverMs @param {number} atMs */
  onPong(sentMs, serverMs, atMs) {
    this.#game.clock.add(sentMs, serverMs, atMs);
  }

  /** @param {Status} status @param {import("../wire/connection.js").Ending} [ending] why the connection ended */
  onStatus(status, ending, why = "") {
    if (status !== this.#status) this.#statusSinceMs = performance.now();
    this.#status = status;
    this.#lossText = why;
    if (status === "over" && this.#study && ending?.kind !== "replaced") return this.#study.leave();
    if (ending === undefined) return;
    this.#root.toggleAttribute("data-refused", this.#game.round === null);
    const watchPath = mode === "play" && ending.kind !== "notFound" ? `/watch/${room}` : "";
    this.#panels.showOver(ending, watchPath);
    if (ending.kind === "unauthorised" && mode === "play") void this.#lookElsewhere(watchPath);
  }

  /** The room is full: perhaps because the same person plays there in another tab. @param {string} watchPath */
  async #lookElsewhere(watchPath) {
    const tokens = await askOtherTabs(room);
    if (tokens.length === 0) return;
    const here = () => {
      saveTokens(room, tokens);
      location.reload();
    };
    this.#panels.showOver({ kind: "elsewhere", sentence: say("play.elsewhere") }, watchPath, here);
  }

  // ---- once per frame ---------------------------------------------------------------------------------------

  /** @param {number} nowMs */
  #frame(nowMs) {
    requestAnimationFrame((next) => this.#frame(next));
    this.#readDevices(nowMs);
    const scene = this.#game.show(nowMs);
    this.#follow(nowMs);
    if (this.#status === "open" && this.#study?.startsNow(this.#game)) this.#each((seat) => this.#ready(seat));
    if (scene !== null && this.#game.round !== null) {
      this.#pings.update(scene.view, nowMs);
      if (!this.#arenaIsGone) this.#arena.draw(scene, nowMs, this.#intents);
      this.#sounds.update(this.#game, scene);
      this.#announcer.update(this.#game, scene, nowMs);
      this.#after.update(this.#game, scene.view);
    }
    if (nowMs - this.#hudAtMs >= HUD_MS) this.#writeWords(scene, nowMs);
    this.#probe.drawn(nowMs, scene, this.#status, this.#intents);
    if (this.#probe.isSlow) this.#arena.paintInMemory();
  }

  /** @param {import("./game.js").Scene | null} scene @param {number} nowMs */
  #writeWords(scene, nowMs) {
    this.#hudAtMs = nowMs;
    const cards = this.#seats.cards();
    const lost = lostText(this.#status, nowMs - this.#statusSinceMs, this.#lossText);
    this.#hud.update(this.#game, scene, this.#status, nowMs);
    this.#hud.showControls(cards, this.#mapping, {
      change: () => this.#openSettings(),
      swap: studyMark === null ? () => this.#seats.swap() : null,
      pings: this.#pings.possible,
    });
    const news = { busy: this.#after.showsResult, lost, deaf: this.#isDeaf(nowMs) };
    const hint = this.#lostPads.hint(this.#game.own);
    this.#panels.update(this.#game, nowMs, { ...news, hint }, cards, this.#mapping);
    this.#tutorial.write(this.#game, cards, this.#mapping);
    this.#decisions.write(this.#game.phase === "paused");
    const touch = mode === "play" && cards.some((card) => card.device === "touch") && !this.#arenaIsGone;
    this.#root.toggleAttribute("data-touch", touch);
    const { phase } = this.#game;
    byId("touch", HTMLElement).hidden = !touch || lost !== "" || !["countdown", "playing"].includes(phase);
    byId("stop", HTMLButtonElement).disabled = mode === "play" && lost !== "" && phase === "playing";
  }

  /** Reacts to a change of phase. @param {number} nowMs */
  #follow(nowMs) {
    if (this.#game.phase === this.#phase) return;
    this.#phase = this.#game.phase;
    this.#phaseSinceMs = nowMs;
    const focused = document.activeElement;
    // The button that was clicked to get here must not take the key that grabs.
    if (mode === "play" && ["countdown", "playing"].includes(this.#phase) && focused instanceof HTMLElement)
      focused.blur();
    if (this.#phase !== "playing") return;
    this.#panels.forgetStop();
    if (this.#dialogIsOpen) this.#pauses.toggle(false); // opened during the countdown
  }

  // ---- devices ----------------------------------------------------------------------------------------------

  /** @param {number} nowMs */
  #readDevices(nowMs) {
    const sends = this.#status === "open" && !document.hidden;
    // Presses belong to a dialog. Frames go on: the server knows from nothing else that the page keeps up.
    if (this.#dialogIsOpen) return sends ? this.#inputs.keepNeutral(nowMs) : undefined;
    const playing = this.#game.phase === "playing";
    for (const [seat, reading] of this.#seats.read(this.#mapping)) {
      this.#intents[seat] = reading.stick;
      if (!playing && reading.grabs > 0) this.#pressedBetween(seat, nowMs);
      if (reading.pings > 0) this.#pings.ask(seat);
      if (sends) this.#inputs.send(seat, playing ? reading : { ...reading, grabs: 0 }, nowMs);
    }
    const { pauses } = this.#seats; // one is enough to pause, and everybody goes on for themselves
    for (const seat of playing ? pauses.slice(0, 1) : pauses) this.#pauses.toggle(true, seat);
    const seat = this.#lostPads.update(this.#seats, this.#game.phase);
    if (seat !== null) this.#pauses.toggle(false, seat);
  }

  /** Between rounds the grab button means "ready". @param {number} seat @param {number} nowMs */
  #pressedBetween(seat, nowMs) {
    const { phase, room: state } = this.#game;
    if (!["lobby", "paused", "round_over"].includes(phase) || this.#after.showsResult) return;
    if (this.#isDeaf(nowMs) || state?.seats.some((one) => one.open)) return;
    if (state?.seats[seat]?.ready === false) this.#ready(seat);
  }

  /**
   * A press that was meant for the round that just stopped does not count; until then the panel asks for none.
   * @param {number} nowMs
   */
  #isDeaf(nowMs) {
    return this.#phase !== "lobby" && nowMs - this.#phaseSinceMs < DEAF_MS;
  }

  #letGo() {
    this.#keyboard.release();
    this.#touch.release();
    this.#inputs.sendNeutral(performance.now());
  }

  #visibility() {
    this.#connection.send({ type: "focus", visible: !document.hidden });
    if (document.hidden) this.#letGo();
    else this.#game.skipToNow();
    this.#probe.hidden();
  }

  // ---- actions of the person --------------------------------------------------------------------------------

  /** @param {(seat: number) => void} action */
  #each(action) {
    for (const seat of this.#game.own) action(seat);
  }

  /** @param {number} seat */
  #ready(seat) {
    this.#lostPads.forget();
    this.#connection.send({ type: "ready", seat, ready: true });
  }

  /** Leaves for good. After a stopped round its result is still shown. */
  #leave() {
    const inRound = ["playing", "paused"].includes(this.#game.phase);
    this.#each((seat) => this.#connection.send({ type: "leave", seat }));
    this.#inputs.hold([]); // the seats are not ours any more
    if (inRound) return this.#after.stopHere();
    this.#connection.close();
    location.assign("/");
  }

  /** Ends the tutorial, which is noted in the recording, and leaves. */
  #skip() {
    const [seat] = this.#game.own;
    if (seat !== undefined && ["playing", "paused"].includes(this.#game.phase))
      this.#connection.send({ type: "skip", seat });
    setTimeout(() => location.assign("/"), SENT_MS);
  }

  #openSettings() {
    if (this.#game.phase === "playing") this.#pauses.toggle(false);
    this.#settings.open();
  }
}

if (studyMark?.map) nameMap(studyMark.map.name, studyMark.map.title);
await Promise.all([prepareTexts(studyMark?.language), readLayout()]); // a round of a study is in the study's language
new Play().start();
