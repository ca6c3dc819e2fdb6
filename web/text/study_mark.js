// @ts-check
/*
 * A note in this tab that a room belongs to a study: written by the study page, read by the game page, which then
 * leads back to the study instead of to the lobby.
 */

const KEY = "movingout-study-round";

/**
 * `name` is what people read: "Round 3 of 12"; `people` who of this screen is blue and who red; `map` the study's own
 * title of the map, where it has one.
 * @typedef {{room: string, key: string, practice: boolean, tutorial?: boolean, sounds?: boolean,
 *   pay?: "paid" | "unpaid", language: string, name: string,
 *   people?: readonly number[], map?: {name: string, title: string}}} StudyMark
 */

/** @param {StudyMark} mark */
export function markStudyRound(mark) {
  try {
    sessionStorage.setItem(KEY, JSON.stringify(mark));
  } catch {
    // without storage the game page cannot know; its start page is the study's in any case
  }
}

/** @param {string} room @returns {StudyMark | null} */
export function studyMarkOf(room) {
  try {
    const mark = JSON.parse(sessionStorage.getItem(KEY) ?? "null");
    return mark?.room === room ? mark : null;
  } catch {
    return null;
  }
}
