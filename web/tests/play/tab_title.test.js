// @ts-check
import assert from "node:assert/strict";
import { test } from "node:test";

import { TabTitle } from "../../play/tab_title.js";
import { speak } from "../text/support.js";

/** @typedef {import("../../messages.js").ServerMessage} ServerMessage */

function tab() {
  /** @type {() => void} */
  let changed = () => {};
  const page = {
    title: "Moving Out Live",
    hidden: false,
    addEventListener: (/** @type {string} */ _, /** @type {() => void} */ heard) => (changed = heard),
  };
  const show = (/** @type {boolean} */ shown) => {
    page.hidden = !shown;
    changed();
  };
  const title = new TabTitle(/** @type {Document} */ (/** @type {unknown} */ (page)));
  const receive = (/** @type {object} */ message) => title.receive(/** @type {ServerMessage} */ (message));
  return { page, show, receive };
}

const round = (/** @type {string} */ name) => ({ type: "round", map: { name, items: [] } });
const room = (/** @type {boolean} */ ready) => ({ type: "room", phase: "lobby", seats: [{ present: true, ready }] });

test("the tab is called after the map that is played, in the reader's language", () => {
  const { page, receive } = tab();
  speak("de");
  receive(round("HandOff:mirror"));
  assert.equal(page.title, "Übergabe, gespiegelt · Moving Out Live");
  speak("en");
  receive(round("LeftRight"));
  assert.equal(page.title, "Left Right · Moving Out Live");
});

test("a dot stands before it from what happens in a hidden tab until it is shown", () => {
  speak("en");
  const { page, show, receive } = tab();
  receive(round("HandOff"));
  receive(room(false));
  show(false);
  receive(room(true));
  receive(room(false));
  assert.equal(page.title, "● Hand Off · Moving Out Live");
  receive(round("LeftRight"));
  assert.equal(page.title, "● Left Right · Moving Out Live");
  show(true);
  assert.equal(page.title, "Left Right · Moving Out Live");
  receive(room(true));
  assert.equal(page.title, "Left Right · Moving Out Live");
});
