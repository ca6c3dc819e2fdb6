"""The shards whose rooms are at this node, and those that are being opened."""

import asyncio
import logging
from collections.abc import Callable, Iterator
from typing import Protocol

from movingout.maps import MovingOutError
from movingout.server.cluster.errors import NodeEnds
from movingout.server.cluster.held_leases import HeldLeases
from movingout.server.cluster.shards import STUDY, lease_title
from movingout.server.cluster.study_tries import StudyTries

log = logging.getLogger(__name__)


class RoomKeeper(Protocol):
    """What a node has done with the rooms of its shards (server.cluster.host.ClusterHost)."""

    async def open_shard(self, shard: str, fence: int) -> None:
        """Go on with the rooms of a shard, as the last node left them. Raises ClusterError."""

    def close_shard(self, shard: str) -> None:
        """Let go of the rooms, at once and without a word to the disk."""

    def room_counts(self) -> dict[str, int]:
        """Rooms by shard."""

    def can_give_back(self, shard: str) -> bool:
        """Whether nothing is left of a shard: no room and no unfinished recording."""

    def forget_shard(self, shard: str, fence: int) -> None:
        """The shard was given back."""

    def can_see(self, shard: str) -> bool:
        """Whether the files of a shard lie in the data folder."""

    async def shards_on_disk(self) -> frozenset[str]:
        """Shards of which rooms or unfinished recordings lie in the data folder."""


class OpenShards:
    """Opens those of `leases`, each in a task of its own; `clock` is in seconds. `in` and iteration: what is open."""

    def __init__(
        self, rooms: RoomKeeper, leases: HeldLeases, study_tries: StudyTries, clock: Callable[[], float]
    ) -> None:
        self._rooms = rooms
        self._leases = leases
        self._study_tries = study_tries
        self._clock = clock
        self._opened_at: dict[str, float] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}

    def __contains__(self, shard: str) -> bool:
        return shard in self._opened_at

    def __iter__(self) -> Iterator[str]:
        return iter(tuple(self._opened_at))

    def since(self, shard: str) -> float:
        """When a shard was opened, by the clock. Raises KeyError where it is not open."""
        return self._opened_at[shard]

    def is_being_opened(self, shard: str) -> bool:
        return shard in self._tasks

    def open_all(self) -> None:
        """Begin to open what there is a lease of and is not open."""
        for shard in self._leases:
            if shard not in self and shard not in self._tasks:
                self._begin(shard)

    def _begin(self, shard: str) -> None:
        task = asyncio.create_task(self._open(shard, self._leases.fence(shard)), name=f"shard {shard}")
        self._tasks[shard] = task
        task.add_done_callback(lambda _: self._tasks.pop(shard, None))

    async def _open(self, shard: str, fence: int) -> None:
        try:
            await self._rooms.open_shard(shard, fence)
        except NodeEnds:
            return
        except MovingOutError as error:
            problem = str(error)
            log.error("%s cannot be opened: %s", lease_title(shard), error)
        except Exception as error:  # tried again in a second
            problem = f"{type(error).__name__}: {error}"
            log.exception("%s cannot be opened: %s", lease_title(shard), error)
        else:
            self._opened_at[shard] = self._clock()
            if shard == STUDY:
                self._study_tries.went_well()
            return
        self._rooms.close_shard(shard)
        if shard == STUDY and self._leases.valid(STUDY, self._clock()):
            self._study_tries.failed(problem)

    async def opened(self) -> None:
        """Open all and wait until their rooms are there; a study waits for those of other nodes, too."""
        self.open_all()
        await asyncio.gather(*(task for shard, task in self._tasks.items() if shard != STUDY))

    async def settled(self) -> None:
        """Wait for everything that is being opened, the study, too."""
        await asyncio.gather(*self._tasks.values())

    async def stop_opening(self, shard: str) -> None:
        """Give up opening a shard, or the study, where that has begun."""
        if (task := self._tasks.get(shard)) is not None:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    def close(self, shard: str) -> None:
        """Let go of its rooms."""
        self.given_back(shard)
        self._rooms.close_shard(shard)

    def given_back(self, shard: str) -> None:
        """It has no rooms any more."""
        self._opened_at.pop(shard, None)
