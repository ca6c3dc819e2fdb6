// Four short sounds, made by WebAudio: grab, miss, delivery, ten seconds left. A sound that cannot play is left out.

import { byId } from "../../core/dom.js";
import { keepSound, wantsSound } from "../../core/sound_choice.js";
import { ticksOf } from "../../core/ticks.js";
import { EVENT } from "../../messages.js";
import { say } from "../../text/catalogue.js";

/** @typedef {import("../game.js").Game} Game */
/** @typedef {import("../game.js").Scene} Scene */
/** @typedef {"grab" | "miss" | "deliver" | "hurry"} SoundName */
/** @typedef {{hz: number, toHz: number, atS: number, lastsS: number, wave: OscillatorType}} Tone */

const LOUDNESS = 0.12;
const LATE_TICKS = ticksOf(10);

/** @type {Readonly<Record<SoundName, readonly Tone[]>>} */
const TONES = {
  grab: [{ hz: 330, toHz: 440, atS: 0, lastsS: 0.08, wave: "triangle" }],
  miss: [{ hz: 150, toHz: 110, atS: 0, lastsS: 0.1, wave: "triangle" }],
  deliver: [
    { hz: 523, toHz: 523, atS: 0, lastsS: 0.1, wave: "sine" },
    { hz: 784, toHz: 784, atS: 0.09, lastsS: 0.18, wave: "sine" },
  ],
  hurry: [
    { hz: 660, toHz: 660, atS: 0, lastsS: 0.07, wave: "sine" },
    { hz: 660, toHz: 660, atS: 0.14, lastsS: 0.07, wave: "sine" },
  ],
};

export class Sounds {
  /** @type {AudioContext | null} made at the first gesture, before which browsers play nothing */
  #audio = null;
  #button = byId("mute", HTMLButtonElement);
  #words = byId("mute-words", HTMLElement);
  #on = wantsSound();
  #tick = 0;
  /** How often each sound was started, for tests. @type {Record<SoundName, number>} */
  played = { grab: 0, miss: 0, deliver: 0, hurry: 0 };

  /** @param {boolean} allowed  a study may have switched sounds off for everybody */
  constructor(allowed) {
    this.#button.hidden = !allowed;
    this.#on &&= allowed;
    if (!allowed) return;
    this.#button.addEventListener("click", () => this.#toggle());
    addEventListener("pointerdown", () => this.#wake());
    addEventListener("keydown", () => this.#wake());
    this.#show();
  }

  /** Once per frame: what was just seen is heard. @param {Game} game @param {Scene} scene */
  update(game, scene) {
    const before = this.#tick;
    this.#tick = scene.tick;
    if (!this.#on) return;
    for (const event of scene.events) {
      const mine = game.own.length === 0 || game.own.includes(event.seat);
      if (event.code === EVENT.grab && mine) this.#play("grab");
      if (event.code === EVENT.grab_failed && mine) this.#play("miss");
      if (event.code === EVENT.delivered) this.#play("deliver");
    }
    const limit = game.tutorial === null ? (game.round?.limit_ticks ?? 0) : 0;
    const late = limit - LATE_TICKS;
    if (late > 0 && before > 0 && before < late && scene.tick >= late) this.#play("hurry");
  }

  #toggle() {
    this.#on = !this.#on;
    keepSound(this.#on);
    this.#show();
    if (this.#on) this.#wake();
    this.#button.blur(); // it must not take the key that grabs
  }

  #show() {
    const words = say(this.#on ? "play.sound.on" : "play.sound.off");
    this.#words.textContent = words;
    this.#button.setAttribute("aria-pressed", String(this.#on));
    this.#button.dataset.on = String(this.#on);
  }

  #wake() {
    if (!this.#on) return;
    try {
      this.#audio ??= new AudioContext();
      // Safari calls it "interrupted" after a call.
      if (this.#audio.state !== "running") void this.#audio.resume().catch(() => {});
    } catch {
      this.#audio = null; // no audio device, or none allowed
    }
  }

  /** @param {SoundName} name */
  #play(name) {
    const audio = this.#audio;
    if (audio === null || audio.state !== "running") return;
    try {
      for (const tone of TONES[name]) start(audio, tone);
      this.played[name] += 1;
    } catch {
      // the game goes on without it
    }
  }
}

/** @param {AudioContext} audio @param {Tone} tone */
function start(audio, { hz, toHz, atS, lastsS, wave }) {
  const [begin, end] = [audio.currentTime + atS, audio.currentTime + atS + lastsS];
  const oscillator = new OscillatorNode(audio, { type: wave, frequency: hz });
  const gain = new GainNode(audio, { gain: 0 });
  oscillator.frequency.linearRampToValueAtTime(toHz, end);
  gain.gain.setValueAtTime(0, begin);
  gain.gain.linearRampToValueAtTime(LOUDNESS, begin + 0.01);
  gain.gain.linearRampToValueAtTime(0, end);
  oscillator.connect(gain).connect(audio.destination);
  oscillator.start(begin);
  oscillator.stop(end);
}
