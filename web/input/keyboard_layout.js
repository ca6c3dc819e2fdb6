// The keys of this keyboard: what is printed on them, and which place a press comes from.

/** @type {{get(code: string): string | undefined}} where the browser does not tell, as on a US keyboard */
let printed = new Map();

/**
 * Asks the browser what is printed on the keys. Only Chromium tells, and only over https or on this machine.
 * @param {{getLayoutMap?(): Promise<{get(code: string): string | undefined}>} | undefined} [keyboard]
 */
export async function readLayout(keyboard = /** @type {any} */ (navigator).keyboard) {
  try {
    printed = (await keyboard?.getLayoutMap?.()) ?? printed;
  } catch {
    // forbidden in a frame of another page
  }
}

/** The letter or sign of a key, such as "Z" for KeyW on a French keyboard. @param {string} code */
export function printedOn(code) {
  const sign = printed.get(code) ?? "";
  if (code.startsWith("Digit") || !/^[\p{L}\p{N}\p{P}\p{S}]$/u.test(sign)) return "";
  return sign.toUpperCase().length === 1 ? sign.toUpperCase() : sign; // not "SS" for "ß"
}

/**
 * The code of a key press. Remote controls and on-screen keyboards may leave it empty: then what the key means counts.
 * @param {Pick<KeyboardEvent, "code" | "key">} press
 */
export function codeOf({ code, key = "" }) {
  if (code) return code;
  if (/^[a-z]$/i.test(key)) return `Key${key.toUpperCase()}`;
  return { " ": "Space", Shift: "ShiftLeft" }[key] ?? key;
}
