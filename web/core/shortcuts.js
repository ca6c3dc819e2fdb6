// @ts-check
/*
 * Which shortcut of a page a key press means: by what is printed on the key, whatever Caps Lock does; where that is no
 * Latin letter, as on a Russian keyboard or for the digits of a French one, by the place of the key.
 */

/** Signs by their place on a US keyboard. @type {Record<string, string>} */
const SIGNS = { Comma: ",", Period: ".", Minus: "-", Equal: "=" };

/**
 * @template Action
 * @param {Readonly<Record<string, Action>>} actions by small letter, sign or name of a key: "r", ",", "ArrowLeft"
 * @param {Pick<KeyboardEvent, "key" | "code" | "shiftKey">} press
 * @returns {Action | undefined}
 */
export function actionFor(actions, { key, code, shiftKey }) {
  const typed = key.length === 1 ? key.toLowerCase() : key;
  if (Object.hasOwn(actions, typed)) return actions[typed];
  if (/^[a-z]$/.test(typed) || typed.length > 1) return undefined;
  if (shiftKey && code.startsWith("Digit")) return undefined; // the other sign of that key
  const place = SIGNS[code] ?? code.replace(/^(Key|Digit)/, "").toLowerCase();
  return Object.hasOwn(actions, place) ? actions[place] : undefined;
}
