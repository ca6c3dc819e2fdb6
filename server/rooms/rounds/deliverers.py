"""Who brought each item home: the seats whose hands held it last, for the page after a round."""

from collections.abc import Sequence

TOGETHER_TICKS = 10  # two who let go within a second brought it together


class Deliverers:
    """Follows the hands of one round."""

    def __init__(self, items: int) -> None:
        self._last_held = [[-1, -1] for _ in range(items)]  # per item and seat: the last tick in that hand

    def see(self, tick: int, held: Sequence[int]) -> None:
        """Take in the item in each hand after a tick, -1 for none."""
        for seat, item in enumerate(held):
            if item >= 0:
                self._last_held[item][seat] = tick

    def of(self, delivered: Sequence[bool]) -> list[list[int]]:
        """Per item the seats that brought it home; empty for one that is not there or that nobody ever held."""
        return [self._seats(item) if there else [] for item, there in enumerate(delivered)]

    def _seats(self, item: int) -> list[int]:
        ticks = self._last_held[item]
        newest = max(ticks)
        return [seat for seat, tick in enumerate(ticks) if tick >= 0 and newest - tick <= TOGETHER_TICKS]
