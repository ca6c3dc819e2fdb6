"""A pause of a round: whom it waits for, how long, and how the round ends when that was too long.

Knows no room and no clock: times (seconds of the server's monotonic clock) are arguments.
"""

from typing import NamedTuple

from movingout.recordings.episode import Outcome
from movingout.server.notices import Notice
from movingout.server.rooms.room_notices import about
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.time_limits import HOLD_LIMIT_S, PAUSE_LIMIT_S


class RoundPause(NamedTuple):
    """Why the game waits, and until when."""

    notice: Notice
    until: float

    @classmethod
    def held(cls, notice: Notice, now: float) -> "RoundPause":
        """The experimenter has stopped the clock."""
        return cls(notice, now + HOLD_LIMIT_S)

    @classmethod
    def waiting_for(cls, seats: list[Seat], resume_s: float, now: float) -> "RoundPause":
        """For absent players, `resume_s` from the first one's departure; then for those not ready."""
        absent = _absent(seats)
        if absent:
            notice = about("waiting", absent, "lost the connection. The game waits.")
            return cls(notice, min(seat.absent_since for seat in absent) + resume_s)
        waiting = [seat for seat in seats if not seat.is_ready]
        notice = about("paused", waiting, "paused the game.") if waiting else Notice("all_back", "Everybody is back.")
        return cls(notice, now + PAUSE_LIMIT_S)


def give_up(seats: list[Seat]) -> tuple[Outcome, Notice]:
    """The pause was too long: absent players are gone for good. How the round ends, and why."""
    absent = _absent(seats)
    for seat in absent:
        seat.gone = True
    if absent:
        return "left", about("not_back", absent, "did not come back.")
    return "stopped", Notice("paused_too_long", "The game was paused for too long.")


def _absent(seats: list[Seat]) -> list[Seat]:
    return [seat for seat in seats if not seat.present]
