// @ts-check
/*
 * The people at this screen while the page is open, one or two: their places in the study, and the newest view of each.
 */

import { savePeople } from "./kept_people.js";
import { Place } from "./service.js";
import { stillHere, whoseTurn } from "./turns.js";

/** @typedef {import("./service.js").View} View */

export class PeopleHere {
  /** @type {Place[]} replaced, never changed, so that a late answer can tell whether others sit here by now */
  places = [];
  /** @type {View[]} one per person; none before the first answer */
  views = [];
  #codeOf = 0; // whose completion code is shown where both have one

  get areTwo() {
    return this.places.length > 1;
  }

  get tokens() {
    return this.places.map((place) => place.token);
  }

  get haveFinished() {
    return this.views.every(({ step }) => step.kind === "code");
  }

  /** @returns {number[]} whose screen is shown */
  get turn() {
    const people = whoseTurn(this.views);
    return this.haveFinished && this.views.length > 1 ? [this.#codeOf] : people;
  }

  /** @returns {number[]} who of those may stop */
  get whoCanStop() {
    return this.turn.filter((person) => this.views[person].can_stop);
  }

  /** @param {readonly number[]} people @returns {import("./service.js").Step[]} */
  steps(people) {
    return people.map((person) => this.views[person].step);
  }

  /** Those whom this browser remembers. @param {readonly string[]} tokens */
  remember(tokens) {
    this.places = tokens.map((token) => new Place(token));
  }

  /** @param {readonly {place: Place, view: View}[]} people */
  seat(people) {
    this.places = people.map(({ place }) => place);
    this.views = people.map(({ view }) => view);
    savePeople(this.tokens);
  }

  /**
   * Keeps the newest views. Of two, the one stays when the other has declined.
   * @param {View[]} views one per person
   * @returns {boolean} whether one has gone
   */
  take(views) {
    const staying = stillHere(views);
    const gone = views.length > 1 && staying.length === 1;
    this.views = gone ? staying.map((person) => views[person]) : views;
    if (!gone) return false;
    this.places = staying.map((person) => this.places[person]);
    savePeople(this.tokens);
    return true;
  }

  /** Shows the completion code of the other one. */
  turnToOtherCode() {
    this.#codeOf = 1 - this.#codeOf;
  }

  forget() {
    this.places = [];
    this.views = [];
    this.#codeOf = 0;
    savePeople([]);
  }
}
