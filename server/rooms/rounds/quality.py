"""Quality of a round, as a study keeps it besides the recording: lateness, round trips, idle and hidden time."""

from statistics import median

from movingout.world.constants import TICK_MS
from movingout.world.state import Floats


class RoundQuality:
    """Counts tick by tick; seats are 0 blue, 1 red."""

    def __init__(self) -> None:
        self._late_ms: list[float] = []
        self._rtt_ms: tuple[list[float], list[float]] = ([], [])
        self._idle = [0, 0]
        self._hidden = [0, 0]
        self._visible = [True, True]

    def tick(self, actions: Floats, rtt_ms: tuple[float, float], late_ms: float) -> None:
        """One tick: `actions` (2, 3) as the world got them, round trips or -1, and how late it began."""
        self._late_ms.append(late_ms)
        for seat, (distance, _, toggle) in enumerate(actions.tolist()):
            self._idle[seat] += distance == 0.0 and toggle < 0.5
            self._hidden[seat] += not self._visible[seat]
            if rtt_ms[seat] >= 0.0:
                self._rtt_ms[seat].append(rtt_ms[seat])

    def focus(self, seat: int, visible: bool) -> bool:
        """The seat's page is visible, or hidden; whether that is new."""
        before, self._visible[seat] = self._visible[seat], visible
        return before != visible

    def late_p99_ms(self) -> float | None:
        """None before the first tick."""
        ordered = sorted(self._late_ms)
        return ordered[min(len(ordered) - 1, int(0.99 * len(ordered)))] if ordered else None

    def rtt_ms(self, seat: int) -> float | None:
        """The median round trip, None where it was never measured."""
        return median(self._rtt_ms[seat]) if self._rtt_ms[seat] else None

    def idle_share(self, seat: int) -> float | None:
        """The share of ticks in which the seat did nothing at all."""
        return self._idle[seat] / len(self._late_ms) if self._late_ms else None

    def hidden_s(self, seat: int) -> float:
        """How long the page was hidden."""
        return self._hidden[seat] * TICK_MS / 1e3
