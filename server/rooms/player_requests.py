"""What players ask of their room. Whether they may ask it in its phase, and how often, has been checked before.

`now` is in seconds of the server's monotonic clock.
"""

from movingout.server.notices import NOTHING
from movingout.server.rooms.phases import IN_ROUND, PhaseEvent
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_notices import about
from movingout.server.rooms.seat import Seat


def set_ready(room: Room, seat: Seat, ready: bool, now: float) -> None:
    """A player is ready, or no longer ready, to play on. Raises WrongRequest for one pause too many."""
    stops = room.phase == "countdown" and not ready
    if stops and room.round.started:
        room.round.pauses.ask(seat, room.seats)
    seat.ready, seat.wants_again = ready, False
    if stops and not room.round.started:
        room.enter(PhaseEvent.CALLED_OFF, NOTHING)
    elif stops or room.phase == "paused":
        room.enter_pause(now)
    else:
        room.announce(now)
    room.try_start(now)


def ask_again(room: Room, seat: Seat, now: float) -> None:
    """A player wants to play the same map again."""
    seat.ready = seat.wants_again = True
    room.announce(now)
    room.try_start(now)


def pause(room: Room, seat: Seat, now: float) -> None:
    """A player pauses the round until ready again. Raises WrongRequest for one pause too many."""
    room.round.pauses.ask(seat, room.seats)
    seat.ready = False
    room.round.note("pause", seat.index)
    room.enter_pause(now)


def skip(room: Room, seat: Seat) -> None:
    """A player ends the tutorial before its last step."""
    room.round.note_skip(seat.index)
    room.finish("stopped", NOTHING)


def retire(room: Room, seat: Seat, now: float) -> None:
    """A player has practised enough: the seat stays idle, and the other may play on."""
    seat.retire()
    room.series.replace_learner(room.round, seat)
    if room.phase == "paused":
        room.enter_pause(now)
    room.announce(now)
    room.try_start(now)


def leave(room: Room, seat: Seat, now: float) -> None:
    """A player leaves for good."""
    left = about("left", [seat], "left the game.")
    if not room.round.started and room.phase in ("lobby", "countdown") and seat.shared:
        free = about("seat_free", [seat], "left; the seat is free again.")
        seat.vacate()
        room.enter(PhaseEvent.CALLED_OFF, free)
        return
    seat.client, seat.absent_since, seat.gone = None, now, True
    if room.round.started and room.phase in IN_ROUND:
        room.finish("left", left)
    else:
        room.enter(PhaseEvent.SERIES_ENDED, left)
