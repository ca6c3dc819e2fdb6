// @ts-check
/*
 * A short sign of a text: texts that differ have, but for rare chance, different ones.
 */

/** FNV-1a, 32 bits, as up to seven of a-z and 0-9. @param {string} text */
export function textHash(text) {
  let value = 0x811c9dc5;
  for (let index = 0; index < text.length; index += 1) {
    value = Math.imul(value ^ text.charCodeAt(index), 0x01000193) >>> 0;
  }
  return value.toString(36);
}
