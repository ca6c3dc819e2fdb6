// @ts-check
/*
 * A button that acts when it is pressed down, not when it is let go. Whatever activates it acts once: a finger, a pen
 * or a mouse, a key on the focused button, a switch, a voice, a screen reader.
 */

const SAME_MS = 500; // a click that follows a pointer within this time is that pointer's
const NO_POINTER = -1; // a screen reader that activates a button brings pointer events of no pointer before its click

/**
 * @param {HTMLElement} button
 * @param {{press: () => void, release?: () => void, click?: () => void}} actions  press: something comes down, several
 *   fingers count as one; release: the last one goes up; click: without a pointer, else as press
 */
export function onPress(button, { press, release = () => {}, click = press }) {
  /** @type {Set<number>} */
  const fingers = new Set();
  let lastMs = -Infinity;
  button.addEventListener("pointerdown", (event) => {
    event.preventDefault(); // neither scrolling nor the focus, which would take the grab key
    if (event.pointerId === NO_POINTER) return;
    lastMs = event.timeStamp;
    fingers.add(event.pointerId);
    if (fingers.size === 1) press();
    button.setPointerCapture(event.pointerId);
  });
  for (const kind of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"])) {
    button.addEventListener(kind, (event) => {
      if (!fingers.delete(event.pointerId)) return;
      lastMs = event.timeStamp;
      if (fingers.size === 0) release();
    });
  }
  button.addEventListener("click", (event) => {
    if (event.detail === 0 && event.timeStamp - lastMs >= SAME_MS) click();
  });
}
