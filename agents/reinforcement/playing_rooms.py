"""The rooms of a learner: they play rounds in this process, or on a cluster (`ray_rooms`)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from torch import Tensor

from movingout.agents.reinforcement.learning_room import Kept, LearningRoom, RoomPairing
from movingout.agents.reinforcement.mappo_config import MappoConfig
from movingout.agents.reinforcement.room_play import RoomPlay, play_room
from movingout.agents.reinforcement.tanh_actor import TanhActor
from movingout.maps.randomize import Split


@dataclass(frozen=True, slots=True)
class LearningRoomSetup:
    """What a room plays; its episodes follow from the seed of the configuration and its number."""

    maps: tuple[str, ...]
    config: MappoConfig
    split: Split | None
    pairing: RoomPairing
    number: int

    def open(self, kept: Kept | None = None) -> LearningRoom:
        """The room at its beginning, or where `kept` was told."""
        room = LearningRoom(self.maps, self.config, self.split, (self.config.seed, self.number), self.pairing)
        if kept is not None:
            room.put_back(kept)
        return room


class PlayingRooms(Protocol):
    """All rooms of a learner, in order."""

    def play(self, actor: TanhActor, frozen: Sequence[TanhActor], noise: Tensor) -> list[RoomPlay]:
        """Play a round in each of K rooms with noise (K, T, 2, 4)."""

    def kept(self) -> list[Kept]:
        """Where each room is."""

    def put_back(self, kept: Sequence[Kept]) -> None:
        """Go on from there."""

    def close(self) -> None:
        """Let go of what other processes hold until the next round."""


class LocalRooms:
    """`PlayingRooms` of this process."""

    def __init__(self, setups: Sequence[LearningRoomSetup]) -> None:
        self.rooms = [setup.open() for setup in setups]

    def play(self, actor: TanhActor, frozen: Sequence[TanhActor], noise: Tensor) -> list[RoomPlay]:
        return [play_room(room, actor, frozen, own) for room, own in zip(self.rooms, noise, strict=True)]

    def kept(self) -> list[Kept]:
        return [room.kept() for room in self.rooms]

    def put_back(self, kept: Sequence[Kept]) -> None:
        for room, one in zip(self.rooms, kept, strict=True):
            room.put_back(one)

    def close(self) -> None:
        """There are no others."""
