// @ts-check
/*
 * The link by which somebody comes to a study: its parameters name the participant, or carry a code or a signature.
 */

const PARAMETERS = [
  "PROLIFIC_PID",
  "STUDY_ID",
  "SESSION_ID",
  "assignmentId",
  "workerId",
  "hitId",
  "turkSubmitTo",
  "code",
  "id",
  "until",
  "sig",
];

/**
 * The parameters that a recruitment platform put into the link, also empty ones: the server refuses these.
 * @param {string} query "?PROLIFIC_PID=…"
 * @returns {Record<string, string>}
 */
export function recruitmentParameters(query) {
  const given = new URLSearchParams(query);
  const names = PARAMETERS.filter((name) => given.has(name) && (name !== "code" || given.get(name))); // it is asked for
  return Object.fromEntries(names.map((name) => [name, String(given.get(name))]));
}
