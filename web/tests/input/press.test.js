// @ts-check
// Buttons that act when pressed: one activation acts once, whoever or whatever it comes from.
import assert from "node:assert/strict";
import { test } from "node:test";

import { Touch } from "../../input/touch.js";

/** A button as far as events go. */
class FakeButton extends EventTarget {
  /** @type {Record<string, string>} */
  attributes = {};
  setAttribute(/** @type {string} */ name, /** @type {string} */ value) {
    this.attributes[name] = value;
  }
  setPointerCapture(/** @type {number} */ pointerId) {
    if (pointerId === -1) throw new Error("no such pointer");
  }
  /** @param {string} kind @param {number} atMs @param {object} more */
  hear(kind, atMs, more) {
    const event = Object.assign(new Event(kind, { cancelable: true }), more);
    Object.defineProperty(event, "timeStamp", { value: atMs });
    this.dispatchEvent(event);
  }
  /** @param {number} atMs @param {{pointerId?: number, detail?: number}} [more] */
  tap(atMs, { pointerId = 2, detail = 1 } = {}) {
    this.hear("pointerdown", atMs, { pointerId });
    this.hear("pointerup", atMs + 60, { pointerId });
    this.hear("click", atMs + 62, { pointerId, detail });
  }
}
const asElement = (/** @type {FakeButton} */ button) => /** @type {HTMLElement} */ (/** @type {unknown} */ (button));

/** The touch controls, the buttons, and how often one grabbed so far. */
function controls() {
  const [zone, knob, grab, backward] = Array.from({ length: 4 }, () => new FakeButton());
  const touch = new Touch(
    { zone: asElement(zone), knob: asElement(knob), grab: asElement(grab), backward: asElement(backward) },
    () => {},
  );
  let sum = 0;
  return { touch, grab, backward, grabs: () => (sum += touch.read().grabs) };
}

test("a tap acts once, as does the next one", () => {
  const { grab, grabs } = controls();
  grab.tap(1000);
  assert.equal(grabs(), 1);
  grab.tap(1200);
  assert.equal(grabs(), 2);
});

test("a screen reader acts once: by a click alone, or with pointer events before it, of a pointer or of none", () => {
  const { grab, grabs } = controls();
  grab.hear("click", 1000, { pointerId: -1, detail: 0 });
  assert.equal(grabs(), 1);
  grab.tap(2000, { pointerId: -1, detail: 0 });
  assert.equal(grabs(), 2);
  grab.tap(3000, { detail: 0 });
  assert.equal(grabs(), 3);
});

test("a key acts after a finger that slid off, and each time that it is pressed", () => {
  const { grab, grabs } = controls();
  grab.hear("pointerdown", 1000, { pointerId: 2 });
  grab.hear("pointercancel", 1500, { pointerId: 2 });
  grab.hear("click", 2500, { pointerId: -1, detail: 0 });
  grab.hear("click", 2700, { pointerId: -1, detail: 0 });
  assert.equal(grabs(), 3);
});

test("two fingers on Grab are one press", () => {
  const { grab, grabs } = controls();
  grab.hear("pointerdown", 1000, { pointerId: 2 });
  grab.hear("pointerdown", 1050, { pointerId: 3 });
  grab.hear("pointerup", 1100, { pointerId: 2 });
  grab.hear("pointerup", 1150, { pointerId: 3 });
  assert.equal(grabs(), 1);
});

test("a finger whose end nobody told is up once its capture is lost", () => {
  const { touch, grab, backward, grabs } = controls();
  backward.hear("pointerdown", 1000, { pointerId: 2 });
  backward.hear("lostpointercapture", 1100, { pointerId: 2 });
  assert.equal(touch.read().backward, false);
  grab.hear("pointerdown", 2000, { pointerId: 3 });
  grab.hear("lostpointercapture", 2100, { pointerId: 3 });
  grab.hear("pointerdown", 3000, { pointerId: 4 });
  assert.equal(grabs(), 2);
});

test("a finger holds Backward while it is down, a screen reader turns it on and off", () => {
  const { touch, backward } = controls();
  backward.hear("pointerdown", 1000, { pointerId: 2 });
  assert.equal(touch.read().backward, true);
  backward.hear("pointerup", 1100, { pointerId: 2 });
  backward.hear("click", 1101, { pointerId: 2, detail: 1 });
  assert.equal(touch.read().backward, false);
  for (const [atMs, on] of /** @type {const} */ ([
    [2000, true],
    [2300, false],
    [4000, true],
  ])) {
    backward.tap(atMs, { pointerId: -1, detail: 0 });
    assert.equal(touch.read().backward, on);
    assert.equal(backward.attributes["aria-pressed"], String(on));
  }
});

test("a page that loses the focus lets go of Backward, and its button says so", () => {
  const { touch, backward } = controls();
  backward.hear("click", 1000, { pointerId: -1, detail: 0 });
  touch.release();
  assert.deepEqual([touch.read().backward, backward.attributes["aria-pressed"]], [false, "false"]);
  touch.release(); // nothing to let go of: nobody has touched anything
  assert.equal(touch.used, false);
});
