"""What a client may ask of its room, and when; everything else is answered with what would be possible."""

from movingout.recordings import InputSample
from movingout.server import messages as m
from movingout.server.frames import Input
from movingout.server.rooms.phases import ALLOWED, Request, names
from movingout.server.rooms.room import Room
from movingout.server.rooms.seat import Listener, Seat
from movingout.server.rooms.services import WrongRequest


def submit(room: Room, client: Listener, frame: Input, now: float) -> None:
    """An input for one seat of this client, and an acknowledgement in any case."""
    if client.acknowledge(frame.ack_tick, now) and room.round.started:
        client.tell(room.full_state())
    seat = room.seats[frame.seat]
    if seat.client is not client:
        raise WrongRequest("not_your_seat", f"the {seat.colour} seat is not yours")
    if seat.controls.submit(frame, now) and room.phase == "playing":
        room.round.recorder.input(
            InputSample(
                room.round.state.tick + 1, seat.index, frame.seq, frame.client_ms, frame.move, frame.heading,
                frame.grabs, m.DEVICES[frame.device], client.rtt_ms,
            )
        )  # fmt: skip


def handle(room: Room, client: Listener, message: m.ClientMessage, now: float) -> None:
    """A control message. Raises WrongRequest with what would work."""
    match message:
        case m.Ready(seat, ready):
            room.set_ready(_own(room, client, seat, "ready"), ready, now)
        case m.Again() if room.config.study:
            raise WrongRequest("study", "a round of a study is played once; go back to the study's page")
        case m.Again(seat):
            room.ask_again(_own(room, client, seat, "again"), now)
        case m.Pause(seat):
            room.pause(_own(room, client, seat, "pause"), now)
        case m.Leave(seat):
            room.leave(_own(room, client, seat, "leave"), now)
        case m.Keyframe():
            client.tell(room.full_state())
        case m.Focus(visible):
            room.focus(client, visible)
        case m.Join():
            raise WrongRequest("joined", "this connection has joined already; open another one")


def _own(room: Room, client: Listener, index: int, request: Request) -> Seat:
    """The client's seat, if the request is possible now."""
    if index not in (0, 1) or room.seats[index].client is not client:
        raise WrongRequest("not_your_seat", f"seat {index} is not yours; your welcome message lists your seats")
    if room.phase not in ALLOWED[request]:
        allowed = names(ALLOWED[request])
        raise WrongRequest("wrong_phase", f"{request} is possible in {allowed}; the room is in {room.phase}")
    return room.seats[index]
