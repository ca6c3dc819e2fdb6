"""Rooms that play on a Ray cluster (extra `cluster`): each processor has some of them from the first round to the last.

They play what they would play here, to the bit, however they are divided. Rooms that were lost with a node are opened
elsewhere where they were before the round, and play it again.
"""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor

from movingout.agents.reinforcement.learning_room import Kept
from movingout.agents.reinforcement.playing_rooms import LearningRoomSetup
from movingout.agents.reinforcement.room_play import RoomPlay, play_room
from movingout.agents.reinforcement.tanh_actor import TanhActor
from movingout.recordings.ray_cluster import NoCluster, connect, processors

TRIES = 5  # of a round, when nodes are lost


class RoomWorker:
    """The actor: some of the rooms."""

    def __init__(self, setups: Sequence[LearningRoomSetup], kept: Sequence[Kept | None]) -> None:
        torch.set_num_threads(1)
        self._rooms = [setup.open(one) for setup, one in zip(setups, kept, strict=True)]

    def play(
        self, networks: tuple[TanhActor, tuple[TanhActor, ...]], noise: Tensor
    ) -> tuple[list[RoomPlay], list[Kept]]:
        """What was played, and where the rooms are now."""
        plays = [play_room(room, *networks, own) for room, own in zip(self._rooms, noise, strict=True)]
        return plays, [room.kept() for room in self._rooms]


class RayRooms:
    """`PlayingRooms` of a cluster, whose workers have shares of them. Raises NoCluster."""

    def __init__(self, address: str, setups: Sequence[LearningRoomSetup]) -> None:
        self._ray = connect(address)
        self._setups = list(setups)
        self._kept: list[Kept | None] = [None] * len(self._setups)
        count = min(processors(), len(self._setups))
        self._shares = [list(range(first, len(self._setups), count)) for first in range(count)]
        self._workers: dict[int, Any] = {}  # by share
        self._lost = False

    def play(self, actor: TanhActor, frozen: Sequence[TanhActor], noise: Tensor) -> list[RoomPlay]:
        networks = self._ray.put((actor, tuple(frozen)))
        plays: dict[int, RoomPlay] = {}
        left = list(range(len(self._shares)))
        for _ in range(TRIES):
            asked = {share: self._worker(share).play.remote(networks, noise[self._shares[share]]) for share in left}
            left = [share for share, answer in asked.items() if not self._take(share, answer, plays)]
            if not left:
                return [plays[number] for number in range(len(self._setups))]
        raise NoCluster(f"the Ray cluster lost the rooms {TRIES} times in one round; is there enough memory?")

    def _take(self, share: int, answer: Any, plays: dict[int, RoomPlay]) -> bool:
        """Keep what a worker played; False when it was lost."""
        try:
            played, kept = self._ray.get(answer)
        except self._ray.exceptions.RayActorError:
            self._workers.pop(share)
            self._lost = True
            return False
        for number, play, now in zip(self._shares[share], played, kept, strict=True):
            plays[number], self._kept[number] = play, now
        return True

    def _worker(self, share: int) -> Any:
        if share not in self._workers:
            # Replacements reserve no processor: the one of a lost node is gone, and waiting for it would never end.
            actor = self._ray.remote(num_cpus=0 if self._lost else 1, scheduling_strategy="SPREAD")(RoomWorker)
            rooms = self._shares[share]
            self._workers[share] = actor.remote(
                [self._setups[number] for number in rooms], [self._kept[number] for number in rooms]
            )
        return self._workers[share]

    def kept(self) -> list[Kept]:
        return [one or setup.open().kept() for one, setup in zip(self._kept, self._setups, strict=True)]

    def put_back(self, kept: Sequence[Kept]) -> None:
        self.close()
        self._kept = list(kept)

    def close(self) -> None:
        """The processors are free for other rooms: CoMeDi has those of one convention after another."""
        for worker in self._workers.values():
            self._ray.kill(worker)
        self._workers.clear()
