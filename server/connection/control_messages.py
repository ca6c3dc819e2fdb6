"""Control messages of a client to its room. A request that is not possible now is answered with when it would be."""

from typing import assert_never

from movingout.server import messages as m
from movingout.server.rooms import player_requests
from movingout.server.rooms.phases import ALLOWED, Request, names
from movingout.server.rooms.room import Room
from movingout.server.rooms.seat import ClientHandle, Seat
from movingout.server.rooms.services import WrongRequest


def handle(room: Room, client: ClientHandle, message: m.ClientMessage, now: float) -> None:
    """Carry out a control message. Raises WrongRequest with what would be possible."""
    match message:
        case m.Ready(seat, ready):
            _set_ready(room, _own(room, client, seat, "ready"), ready, now)
        case m.Again() if room.config.study:
            raise WrongRequest("study", "a round of a study is played once; go back to the study's page")
        case m.Again(seat):
            _ask_again(room, _own(room, client, seat, "again"), now)
        case m.Pause(seat):
            player_requests.pause(room, _own(room, client, seat, "pause"), now)
        case m.SayPing() if not room.config.pings:
            raise WrongRequest("pings_off", "there are no pings in this room")
        case m.SayPing(seat, item):
            ping = room.round.ping(_own(room, client, seat, "ping").index, item, now)
            for each in room.seating.clients:
                each.tell(ping)
        case m.Leave(seat):
            player_requests.leave(room, _own(room, client, seat, "leave"), now)
        case m.Skip() if room.config.study or not room.config.tutorial:
            raise WrongRequest("no_tutorial", "only a tutorial of the lobby is skipped; in a study its page does that")
        case m.Skip(seat):
            player_requests.skip(room, _own(room, client, seat, "skip"))
        case m.Keyframe():
            client.tell(room.full_state())
        case m.Focus(visible):
            room.focus(client, visible)
        case m.Join():
            raise WrongRequest("joined", "this connection has joined already; open another one")
        case _:
            assert_never(message)


def _own(room: Room, client: ClientHandle, index: int, request: Request) -> Seat:
    """The client's seat, if it may make the request now. Raises WrongRequest."""
    if index not in (0, 1) or room.seats[index].client is not client:
        raise WrongRequest("not_your_seat", f"seat {index} is not yours; your welcome message lists your seats")
    if room.phase not in ALLOWED[request]:
        allowed = names(ALLOWED[request])
        raise WrongRequest("wrong_phase", f"{request} is possible in {allowed}; the room is in {room.phase}")
    return room.seats[index]


def _set_ready(room: Room, seat: Seat, ready: bool, now: float) -> None:
    if (seat.ready, seat.wants_again) != (ready, False):
        _count_change(seat, now)
        player_requests.set_ready(room, seat, ready, now)


def _ask_again(room: Room, seat: Seat, now: float) -> None:
    if not (seat.ready and seat.wants_again):
        _count_change(seat, now)
        player_requests.ask_again(room, seat, now)


def _count_change(seat: Seat, now: float) -> None:
    """Everybody in the room hears of each change, and may have a slow line. Raises WrongRequest for one too many."""
    if not seat.changes.take(now):
        raise WrongRequest("ready_rate", "too many changes; wait a second")
