"""What a node may believe of its leases between two answers of the database. Pure: times are arguments, in seconds."""

from collections.abc import Collection, Iterator

from movingout.server.settings import LEASE_S

MARGIN_S = 0.5  # a node stops so long before others may take its rooms: their clocks may run a little faster


class HeldLeases:
    """The leases of one node by shard, with their fencing tokens.

    A lease was renewed some time after the call began, so it lasts at least LEASE_S from then. While no other node
    can reach the data folder, nobody can take its rooms, and they go on without the database.
    """

    def __init__(self, lease_s: float = LEASE_S) -> None:
        self._lease_s = lease_s
        self._fences: dict[str, int] = {}
        self._until: dict[str, float] = {}
        self.shared = False  # once true, always true

    def __iter__(self) -> Iterator[str]:
        return iter(tuple(self._fences))

    def __contains__(self, shard: str) -> bool:
        return shard in self._fences

    @property
    def fences(self) -> dict[str, int]:
        return dict(self._fences)

    def fence(self, shard: str) -> int:
        return self._fences[shard]

    def taken(self, shard: str, fence: int, asked_at: float) -> None:
        self._fences[shard] = fence
        self._until[shard] = asked_at + self._lease_s - MARGIN_S

    def renewed(self, kept: Collection[str], asked_at: float) -> frozenset[str]:
        """The database has answered; returns what is lost for good."""
        lost = frozenset(self._fences) - frozenset(kept)
        for shard in lost:
            self.dropped(shard)
        for shard in self._fences:
            self._until[shard] = asked_at + self._lease_s - MARGIN_S
        return lost

    def dropped(self, shard: str) -> None:
        self._fences.pop(shard, None)
        self._until.pop(shard, None)

    def valid(self, shard: str, now: float) -> bool:
        """Whether this node, and no other, may go on with the rooms of a shard."""
        return shard in self._fences and (not self.shared or now < self._until[shard])
