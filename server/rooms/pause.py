"""A pause of a round: whom it waits for, how long, and what follows when that was too long.

Knows no room and no clock: times (seconds of the server's monotonic clock) are arguments.
"""

from collections.abc import Sequence
from typing import NamedTuple

from movingout.recordings.episode import Outcome
from movingout.server.notices import Notice
from movingout.server.rooms.room_notices import about
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import WrongRequest
from movingout.server.rooms.time_limits import DROP_S, HOLD_LIMIT_S, PAUSE_LIMIT_S, PAUSES, RETURNS, WAIT_LIMIT_S

LONGEST_STEP_S = 1.0  # of waiting time: a server that stood still makes nobody's budget smaller


class PauseBudget:
    """What each player may have others wait in a round, so that nobody is held by pauses that come again and again.

    Pauses that a player asks for and lost connections are counted apart.
    """

    def __init__(self) -> None:
        self._pauses = [0, 0]
        self._waited_s = [0.0, 0.0]
        self._absent_s = [0.0, 0.0]
        self._counted = 0.0  # until when

    def ask(self, seat: Seat, seats: Sequence[Seat]) -> None:
        """Count a pause of `seat`. Raises WrongRequest when the other player has waited enough for this one."""
        if not any(other.taken_by_client and other.present for other in seats if other.client is not seat.client):
            return
        if self._pauses[seat.index] >= PAUSES or self._left_s(seat) <= 0.0:
            text = f"a player pauses a round up to {PAUSES} times and for {WAIT_LIMIT_S:.0f} s in all; the game goes on"
            raise WrongRequest("pauses_used", text)
        self._pauses[seat.index] += 1

    def drop(self, seat: Seat, seats: Sequence[Seat]) -> None:
        """A connection was lost: even a short absence costs the other player the countdown that follows."""
        if seat in _missed(seats):
            self._absent_s[seat.index] += DROP_S

    def count(self, seats: Sequence[Seat], now: float) -> None:
        """Called in every tick of a pause: who is waited for has less time left."""
        step, self._counted = min(now - self._counted, LONGEST_STEP_S), now
        for seat in delaying(seats):
            self._waited_s[seat.index] += step
        for seat in _missed(seats):
            self._absent_s[seat.index] += step

    def wait_until(self, absent: Seat, resume_s: float, now: float) -> float:
        """When a player has been away too long: `resume_s` this time, or RETURNS times that in the whole round."""
        return min(absent.absent_since + resume_s, now + max(0.0, self._returns_s(absent, resume_s)))

    def used_up(self, absent: Seat, resume_s: float) -> bool:
        """Whether this player's absences were too many for one round, however short this one is."""
        return self._returns_s(absent, resume_s) <= 0.0

    def begin(self, now: float) -> None:
        """A pause begins, or goes on with others."""
        self._counted = now

    def end(self, seats: Sequence[Seat], now: float) -> float:
        """When a pause for players who are not ready ends at the latest."""
        late = delaying(seats)
        return now + (max(0.0, *(self._left_s(seat) for seat in late)) if late else PAUSE_LIMIT_S)

    def _left_s(self, seat: Seat) -> float:
        return WAIT_LIMIT_S - self._waited_s[seat.index]

    def _returns_s(self, seat: Seat, resume_s: float) -> float:
        return RETURNS * resume_s - self._absent_s[seat.index]


def delaying(seats: Sequence[Seat]) -> list[Seat]:
    """The players who are not ready while others elsewhere are; nobody while somebody is absent."""
    people = [seat for seat in seats if seat.taken_by_client]
    ready = {seat.client for seat in people if seat.is_ready}
    if _absent(seats):
        return []
    return [seat for seat in people if not seat.is_ready and ready - {seat.client}]


class RoundPause(NamedTuple):
    """Why the game waits, and until when."""

    notice: Notice
    until: float

    @classmethod
    def held(cls, notice: Notice, now: float) -> "RoundPause":
        """The experimenter has stopped the clock."""
        return cls(notice, now + HOLD_LIMIT_S)

    @classmethod
    def waiting_for(cls, seats: list[Seat], resume_s: float, budget: PauseBudget, now: float) -> "RoundPause":
        """For absent players, `resume_s` from the first one's departure; then for those not ready."""
        budget.begin(now)
        absent = _absent(seats)
        if absent:
            notice = about("waiting", absent, "lost the connection. The game waits.")
            return cls(notice, min(budget.wait_until(seat, resume_s, now) for seat in absent))
        waiting = [seat for seat in seats if seat.taken_by_client and not seat.is_ready]  # an agent only loads
        notice = about("paused", waiting, "paused the game.") if waiting else Notice("all_back", "Everybody is back.")
        return cls(notice, budget.end(seats, now))


def play_on(seats: Sequence[Seat]) -> bool:
    """The pause was too long for those who are ready: the others count as ready too. False where nobody waits."""
    late = delaying(seats)
    for seat in late:
        seat.ready = True
    return bool(late)


def give_up(seats: list[Seat], resume_s: float, budget: PauseBudget) -> tuple[Outcome, Notice]:
    """The pause was too long: absent players are gone for good. How the round ends, and why."""
    absent = _absent(seats)
    unsteady = [seat for seat in absent if budget.used_up(seat, resume_s)]
    for seat in absent:
        seat.gone = True
    if unsteady:
        return "left", about("unsteady", unsteady, "lost the connection too often.")
    if absent:
        return "left", about("not_back", absent, "did not come back.")
    return "stopped", Notice("paused_too_long", "The game was paused for too long.")


def _missed(seats: Sequence[Seat]) -> list[Seat]:
    """The absent players whom somebody who is present waits for."""
    absent = _absent(seats)
    return absent if any(seat.taken_by_client and seat.present for seat in seats) else []


def _absent(seats: Sequence[Seat]) -> list[Seat]:
    return [seat for seat in seats if not seat.present]
