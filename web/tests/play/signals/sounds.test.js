// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { Sounds } from "../../../play/signals/sounds.js";
import { speak } from "../../text/support.js";

speak("en");

class FakeElement extends EventTarget {
  dataset = {};
  setAttribute() {}
}

/** @type {{state: string, resumed: number}[]} */
const contexts = [];
class FakeAudio {
  state = "running";
  resumed = 0;
  constructor() {
    contexts.push(this);
  }
  async resume() {
    this.resumed += 1;
    this.state = "running";
  }
}

test("a press brings the sound back wherever it does not run, also after a call", () => {
  const page = new EventTarget();
  Object.assign(globalThis, {
    HTMLElement: FakeElement,
    HTMLButtonElement: FakeElement,
    AudioContext: FakeAudio,
    document: { getElementById: () => new FakeElement() },
    addEventListener: page.addEventListener.bind(page),
  });
  new Sounds(true);
  page.dispatchEvent(new Event("pointerdown"));
  const [audio] = contexts;
  for (const state of ["suspended", "interrupted", "running"]) {
    audio.state = state;
    page.dispatchEvent(new Event("keydown"));
    assert.equal(audio.state, "running");
  }
  assert.equal(audio.resumed, 2);
});
