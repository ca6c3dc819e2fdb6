"""The pings of a round: how often each seat may say one, and which are shown now."""

from movingout.server.connection.token_bucket import TokenBucket
from movingout.server.rooms.services import WrongRequest
from movingout.world.ping import HelpPing, said, shown
from movingout.world.state import WorldState

PER_S = 1.0  # of one seat
BURST = 2.0


class RoundPings:
    """Knows no phase and no client; times are seconds of the server's clock."""

    def __init__(self) -> None:
        self.refused: dict[int, int] = {}  # how many were too many, by seat
        self._pings: tuple[HelpPing, ...] = ()
        self._buckets: dict[int, TokenBucket] = {}

    def say(self, state: WorldState, seat: int, item: int, now: float) -> HelpPing:
        """The ping of a seat in `state`. Raises WrongRequest where there is no such item, or when it is too many."""
        bucket = self._buckets.setdefault(seat, TokenBucket(PER_S, BURST, now))
        if not bucket.take(now):
            self.refused[seat] = self.refused.get(seat, 0) + 1
            raise WrongRequest("ping_rate", "too many pings; wait a second")
        try:
            ping = said(state, seat, item)
        except IndexError as error:
            raise WrongRequest("ping_item", f"{error}; -1 is your own place") from None
        self._pings = (*shown(self._pings, state.tick), ping)
        return ping

    def shown(self, tick: int) -> tuple[HelpPing, ...]:
        """Those that are shown after `tick` ticks, oldest first."""
        self._pings = shown(self._pings, tick)
        return self._pings
