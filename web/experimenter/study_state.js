// @ts-check
/*
 * The state of a study as the experimenter's page knows it: whole at first, then what has changed.
 */

/** @typedef {import("./words.js").StudyState} StudyState */
/** @typedef {import("./words.js").ParticipantRow} ParticipantRow */
/** @typedef {Partial<StudyState> & {partial?: boolean, gone?: string[], more?: ParticipantRow[]}} StudyNews */

/**
 * The state after news; rows keep their order of arrival, and unchanged ones stay the same objects.
 * @param {StudyState | null} state
 * @param {StudyNews} news
 * @returns {StudyState | StudyNews}
 */
export function merged(state, news) {
  if (state === null || (!news.partial && !news.more)) return news;
  const rows = new Map(state.participants.map((row) => [row.pid, row]));
  for (const row of news.more ?? news.participants ?? []) rows.set(row.pid, row);
  for (const pid of news.gone ?? []) rows.delete(pid);
  return { ...state, ...(news.more ? {} : news), participants: [...rows.values()] };
}
