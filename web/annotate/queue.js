// @ts-check
/*
 * The findings to judge and what was said about them. Pure.
 */

/** @typedef {"confirmed" | "rejected" | "unsure"} Verdict */
/**
 * @typedef {object} Finding one failure case that the rules found
 * @property {string} id
 * @property {string} recording episode id
 * @property {string} map name
 * @property {string} case keeps, stays_away or no_grasp
 * @property {number} seat who failed: 0 blue, 1 red
 * @property {number} item index
 * @property {number} start first tick
 * @property {number} end first tick after
 * @property {boolean} human whether a person sat there
 */
/** @typedef {{verdict: Verdict, note: string}} Said */
/** @typedef {Readonly<Record<string, Said>>} SaidById */
/** @typedef {"loading" | "shown" | "unreadable"} Sight of the replay of a finding */

export const CASES = /** @type {const} */ (["keeps", "stays_away", "no_grasp"]);

/**
 * @param {readonly Finding[]} findings
 * @param {{kind: string, who: string}} wanted a case or "", and "agents", "people" or ""
 */
export function wantedFindings(findings, { kind, who }) {
  return findings.filter(
    (one) => (kind === "" || one.case === kind) && (who === "" || one.human === (who === "people")),
  );
}

/**
 * The first finding after `current` that nobody judged here, from the start again after the last; null for none.
 * @param {readonly Finding[]} findings
 * @param {SaidById} said
 * @param {string} current id, "" for none
 */
export function nextOpen(findings, said, current) {
  const from = findings.findIndex((one) => one.id === current) + 1;
  return [...findings.slice(from), ...findings.slice(0, from)].find((one) => !(one.id in said)) ?? null;
}

/**
 * The finding before or after `current`; the first one where there is no current one, null where there is none.
 * @param {readonly Finding[]} findings @param {string} current @param {-1 | 1} direction
 */
export function neighbour(findings, current, direction) {
  const at = findings.findIndex((one) => one.id === current);
  return (at < 0 ? findings[0] : findings[at + direction]) ?? null;
}

/**
 * Whether a finding can be judged so: one that was not seen cannot, and of one whose recording cannot be opened nobody
 * can tell.
 * @param {Verdict} verdict @param {Sight} sight
 */
export function mayJudge(verdict, sight) {
  return sight === "shown" || (sight === "unreadable" && verdict === "unsure");
}

/** How many of the findings are judged. @param {readonly Finding[]} findings @param {SaidById} said */
export function judged(findings, said) {
  return findings.filter((one) => one.id in said).length;
}

/** Whether agents failed and people did: then it is worth a choice. @param {readonly Finding[]} findings */
export function hasBoth(findings) {
  return findings.some((one) => one.human) && findings.some((one) => !one.human);
}
