"""How many websockets there are by address."""

from collections import defaultdict

from movingout.server.connection.networks import counted_as


class SocketCounts:
    """Of one process. Addresses are groups as `admission.address_group` makes them; their networks count, too."""

    def __init__(self) -> None:
        self.total = 0
        self.open: defaultdict[str, int] = defaultdict(int)
        self.waiting: defaultdict[str, int] = defaultdict(int)  # that have not joined a room yet

    def entered(self, address: str) -> None:
        """One more; it is to be `joined` and `left`."""
        self.total += 1
        for group, _ in counted_as(address):
            self.open[group] += 1
            self.waiting[group] += 1

    def joined(self, address: str) -> None:
        _count_down(self.waiting, address)

    def left(self, address: str) -> None:
        self.total -= 1
        _count_down(self.open, address)


def _count_down(counts: defaultdict[str, int], address: str) -> None:
    for group, _ in counted_as(address):
        counts[group] -= 1
        if counts[group] <= 0:
            del counts[group]
