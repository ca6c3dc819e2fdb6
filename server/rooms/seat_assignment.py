"""Who may join a room, and which seats they get: by token, or by the link when a seat is open."""

from collections.abc import Callable

import msgspec

from movingout import __version__
from movingout.recordings.episode import ROOM_PSEUDONYM
from movingout.server import messages as m
from movingout.server.frames import FRAME_FIELDS
from movingout.server.notices import Notice
from movingout.server.rooms.seat import ClientHandle, Seat
from movingout.server.rooms.services import Refused, RoomConfig

MAX_SPECTATORS = 30


class SeatAssignment:
    """The clients of one room and the seats they hold."""

    def __init__(
        self,
        room_id: str,
        seats: list[Seat],
        new_token: Callable[[], str],
        new_id: Callable[[], str],
        takes_names: bool = True,
    ) -> None:
        """`takes_names`: whether people are called what they say; in a study nobody can tell a partner anything."""
        self.clients: list[ClientHandle] = []
        self.taken_at = 0.0  # when somebody last took a free seat
        self._spectators: list[ClientHandle] = []  # of the clients, those who joined to watch
        self._room_id = room_id
        self._seats = seats
        self._new_token = new_token
        self._new_id = new_id
        self._takes_names = takes_names

    @property
    def spectators(self) -> int:
        """How many watch; who has left their seat and reads the result is none of them."""
        return len(self._spectators)

    def seats_of(self, client: ClientHandle) -> list[Seat]:
        return [seat for seat in self._seats if seat.client is client]

    def seat_of_token(self, token: str) -> Seat | None:
        return next((seat for seat in self._seats if seat.knows(token)), None)

    def was_token(self, token: str) -> bool:
        """Whether this is or recently was the token of a seat here."""
        return any([seat.knew(token) for seat in self._seats])

    def join(self, client: ClientHandle, request: m.Join, now: float) -> tuple[list[m.SeatGrant], list[ClientHandle]]:
        """The client's seats with their new tokens, and the clients that lose theirs. Raises Refused."""
        if request.mode == "watch":
            self._admit_spectator(client)
            return [], []
        wanted = self._by_token(request.tokens)
        wanted += self._by_claim(request, wanted)
        if not wanted:
            raise Refused(
                m.CLOSE_UNAUTHORISED,
                "room_full",
                f"This room is full. To watch, open /watch/{self._room_id}.",
            )
        replaced = self._unseat([seat.client for seat in wanted if seat.client is not None], wanted)
        if any(seat.token is None for seat in wanted):  # to come back is nothing new
            self.taken_at = now
        grants = [self._sit(client, seat, request) for seat in wanted]
        self.clients.append(client)
        return grants, replaced

    def welcome(self, mode: m.Mode, taken: list[m.SeatGrant], config: RoomConfig) -> m.Welcome:
        """The answer to a client that has joined."""
        return m.Welcome(
            protocol=m.PROTOCOL, build=__version__, room=self._room_id, mode=mode, seats=taken,
            resume_s=config.resume_s, join_path=f"/play/{self._room_id}", watch_path=f"/watch/{self._room_id}",
            study=bool(config.study), pings=config.pings, frames=FRAME_FIELDS,
        )  # fmt: skip

    def depart(self, client: ClientHandle, now: float) -> list[Seat]:
        """Remove a client; returns the seats that have lost their player."""
        if client in self.clients:
            self.clients.remove(client)
        if client in self._spectators:
            self._spectators.remove(client)
        dropped = self.seats_of(client)
        for seat in dropped:
            seat.client, seat.absent_since = None, now
        return dropped

    def confirm(self, client: ClientHandle) -> None:
        """The client has answered its welcome: its new tokens have arrived."""
        for seat in self.seats_of(client):
            seat.confirm()

    def tell(self, message: m.ServerMessage) -> None:
        """Send a control message to everybody."""
        text = msgspec.json.encode(message).decode()
        for client in self.clients:
            client.tell(message, text)

    def dismiss(self, code: int, notice: Notice) -> None:
        """Close every connection."""
        for client in list(self.clients):
            client.dismiss(code, notice)

    def _admit_spectator(self, client: ClientHandle) -> None:
        if self.spectators >= MAX_SPECTATORS:
            raise Refused(
                m.CLOSE_RETRY_LATER,
                "watchers_full",
                f"{MAX_SPECTATORS} people are watching this room already; try again later.",
            )
        self.clients.append(client)
        self._spectators.append(client)

    def _by_token(self, tokens: list[str]) -> list[Seat]:
        found = [self.seat_of_token(token) for token in tokens[: len(self._seats)]]
        if any(seat is None for seat in found) or len(tokens) > len(self._seats):
            raise Refused(
                m.CLOSE_UNAUTHORISED,
                "wrong_token",
                "This seat's key is no longer valid; open the link of the room again.",
            )
        return list({seat.index: seat for seat in found if seat is not None}.values())

    def _by_claim(self, request: m.Join, already: list[Seat]) -> list[Seat]:
        kind = "remote" if request.program else "human"
        free = [seat for seat in self._seats if seat.open and seat.kind == kind and seat not in already]
        return free[: request.claim]

    def _unseat(self, clients: list[ClientHandle], wanted: list[Seat]) -> list[ClientHandle]:
        """The clients that lose their last seat; one that keeps another seat stays."""
        replaced = []
        for client in {id(each): each for each in clients}.values():
            if all(seat in wanted for seat in self.seats_of(client)):
                self.clients.remove(client)
                replaced.append(client)
        return replaced

    def _sit(self, client: ClientHandle, seat: Seat, request: m.Join) -> m.SeatGrant:
        token = self._new_token()
        seat.alias = seat.alias or f"{ROOM_PSEUDONYM}{self._new_id()[:6]}"
        seat.sit(client, token, request.name if self._takes_names else "", shown=request.tokens)
        return m.SeatGrant(seat.index, token)
