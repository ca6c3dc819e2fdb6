"""How many websockets there are by address."""

from collections import defaultdict


class SocketCounts:
    """Of one process. Addresses are groups as `admission.address_group` makes them."""

    def __init__(self) -> None:
        self.total = 0
        self.open: defaultdict[str, int] = defaultdict(int)
        self.waiting: defaultdict[str, int] = defaultdict(int)  # that have not joined a room yet

    def entered(self, address: str) -> None:
        """One more; it is to be `joined` and `left`."""
        self.total += 1
        self.open[address] += 1
        self.waiting[address] += 1

    def joined(self, address: str) -> None:
        _count_down(self.waiting, address)

    def left(self, address: str) -> None:
        self.total -= 1
        _count_down(self.open, address)


def _count_down(counts: defaultdict[str, int], address: str) -> None:
    counts[address] -= 1
    if counts[address] <= 0:
        del counts[address]
