// The title of the tab: the map that is played, and a dot while the tab is hidden and something has happened in the
// room: somebody came, left or is ready.

import { mapTitle } from "../text/names.js";

const DOT = "● ";

export class TabTitle {
  #known = "";
  #page;
  #site;

  /** @param {Pick<Document, "title" | "hidden" | "addEventListener">} [page] */
  constructor(page = document) {
    this.#page = page;
    this.#site = page.title;
    page.addEventListener("visibilitychange", () => {
      if (!page.hidden && page.title.startsWith(DOT)) page.title = page.title.slice(DOT.length);
    });
  }

  /** @param {import("../messages.js").ServerMessage} message */
  receive(message) {
    const dot = this.#page.title.startsWith(DOT) ? DOT : "";
    if (message.type === "round") {
      const { map } = /** @type {import("./game.js").Round} */ (message);
      this.#page.title = `${dot}${mapTitle(map)} · ${this.#site}`;
    }
    if (message.type === "room" && this.#isNews(message) && this.#page.hidden && !dot)
      this.#page.title = DOT + this.#page.title;
  }

  /** Whether somebody came, left or is ready. @param {import("../messages.js").RoomState} room */
  #isNews(room) {
    const before = this.#known;
    this.#known = JSON.stringify([room.phase, room.seats.map((seat) => [seat.present, seat.ready])]);
    return before !== "" && before !== this.#known;
  }
}
