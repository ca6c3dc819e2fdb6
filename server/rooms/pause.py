"""A pause of a round: whom it waits for, how long, and how the round ends when that was too long.

Knows no room and no clock: times (seconds of the server's monotonic clock) are arguments.
"""

from typing import NamedTuple

from movingout.recordings.episode import Outcome
from movingout.server.rooms.seat import Seat

PAUSE_LIMIT_S = 600.0
HOLD_LIMIT_S = 24 * 3600.0  # for whoever runs a study
RESTART_RESUME_S = 120.0  # for people to come back after the server was started again


class RoundPause(NamedTuple):
    """Why the game waits, in a sentence, and until when."""

    reason: str
    until: float

    @classmethod
    def held(cls, reason: str, now: float) -> "RoundPause":
        """Whoever runs a study has stopped the clock."""
        return cls(reason, now + HOLD_LIMIT_S)

    @classmethod
    def waiting_for(cls, seats: list[Seat], resume_s: float, now: float) -> "RoundPause":
        """For who is absent, `resume_s` from the first who went; then for who is not ready."""
        absent = _absent(seats)
        if absent:
            reason = f"{_names(absent)} lost the connection. The game waits."
            return cls(reason, min(seat.absent_since for seat in absent) + resume_s)
        waiting = [seat for seat in seats if not seat.is_ready]
        return cls(f"{_names(waiting)} paused the game." if waiting else "Everybody is back.", now + PAUSE_LIMIT_S)


def give_up(seats: list[Seat]) -> tuple[Outcome, str]:
    """The pause was too long: who is absent is gone for good. How the round ends with that, and why."""
    absent = _absent(seats)
    for seat in absent:
        seat.gone = True
    if absent:
        return "left", f"{_names(absent)} did not come back."
    return "stopped", "The game was paused for too long."


def _absent(seats: list[Seat]) -> list[Seat]:
    return [seat for seat in seats if not seat.present]


def _names(seats: list[Seat]) -> str:
    return " and ".join(seat.title for seat in seats)
