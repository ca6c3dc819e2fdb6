// A dot in the title of a hidden tab says that something has happened in the room: somebody came, left or is ready.

const DOT = "● ";

export class TabTitle {
  #known = "";

  constructor() {
    document.addEventListener("visibilitychange", () => {
      if (!document.hidden && document.title.startsWith(DOT)) document.title = document.title.slice(DOT.length);
    });
  }

  /** @param {import("../messages.js").RoomState} room */
  receive(room) {
    const now = JSON.stringify([room.phase, room.seats.map((seat) => [seat.present, seat.ready])]);
    const isNews = this.#known !== "" && now !== this.#known;
    this.#known = now;
    if (isNews && document.hidden && !document.title.startsWith(DOT)) document.title = DOT + document.title;
  }
}
