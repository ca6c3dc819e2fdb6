"""The configuration of a room, and what it needs from the process around it."""

from pathlib import Path
from typing import Any, Protocol

import msgspec

from movingout.maps import MapSpec, load_map, map_from_json
from movingout.maps.errors import MovingOutError
from movingout.maps.randomize import Split
from movingout.recordings import EpisodeHeader, EpisodeWriter
from movingout.server import messages as m
from movingout.server.notices import ErrorCode, Notice
from movingout.server.rooms.seat import AgentSource
from movingout.world import WorldState
from movingout.world.constants import LIMIT_TICKS

RESUME_S = 30.0  # how long a seat waits for its player to return


class RoomConfig(msgspec.Struct, frozen=True, kw_only=True):
    """The series of a room."""

    maps: tuple[str, ...]
    limit_ticks: int = LIMIT_TICKS  # per round; for practice only within a study
    practice: bool = False  # does not count, and is not recorded unless it is a tutorial
    tutorial: bool = False  # practice on the map of the tutorial, in its steps
    challenge2_seed: int | None = None
    split: Split = "train"  # of the shapes that randomised maps may have
    countdown_s: float = 3.0
    resume_s: float = RESUME_S
    pings: bool = False  # whether players may point at places and items
    study: dict[str, str] = {}  # pseudonymous ids for the recording; empty for rooms of the lobby
    owner: str = ""  # who has opened it, as limits of an address count rooms; empty for nobody who has limits
    own_maps: dict[str, dict[str, Any]] = {}  # by name: the JSON of maps that are not shipped, as they were then

    def designed(self, index: int) -> MapSpec:
        """The map of a round, without changed items. Raises MapError."""
        own = self.own_maps.get(self.maps[index])
        return load_map(self.maps[index]) if own is None else map_from_json(own)

    def variant_seed(self, index: int) -> int | None:
        """Of the variant of the map of a round, None for the map as designed."""
        return None if self.challenge2_seed is None else self.challenge2_seed + index

    @property
    def round_ticks(self) -> int:
        """The limit of a round, 0 for none."""
        return 0 if self.practice and not self.study and not self.tutorial else self.limit_ticks

    @property
    def recorded(self) -> bool:
        return self.tutorial or not self.practice


class Services(Protocol):
    """What a room needs from outside; tests pass a small fake."""

    @property
    def agents(self) -> AgentSource: ...

    def world_map(self, designed: MapSpec, seed: int | None, split: Split) -> MapSpec: ...

    def map_is_ready(self, designed: MapSpec, seed: int | None, split: Split) -> bool:
        """Whether `world_map` answers at once; otherwise it will. Raises MapError where there is no such map."""

    def open_recording(self, header: EpisodeHeader, initial: WorldState) -> EpisodeWriter:
        """Begin the recording of a round. Raises RecordingError when the disk refuses."""

    def archive(self, journal: Path) -> None:
        """Finalise a closed journal in the background."""

    def ended(self, room_id: str, episode_id: str, result: m.Result) -> None:
        """A round is over and its recording is closed."""

    def new_id(self) -> str: ...

    def new_episode_id(self, room_id: str) -> str:
        """A new name of an episode; it begins like its room's."""

    def new_token(self) -> str: ...

    def wall_ns(self) -> int: ...

    def changed(self, room_id: str) -> None:
        """The room has changed in a way that a restart must know."""


class Refused(MovingOutError):
    """A client may not join. `code` is the websocket close code."""

    def __init__(self, code: int, error: ErrorCode, message: str) -> None:
        super().__init__(message)
        self.code = code
        self.notice = Notice(error, message)


class WrongRequest(MovingOutError):
    """A request that is not possible now; the client is told and stays connected."""

    def __init__(self, code: ErrorCode, message: str) -> None:
        super().__init__(message)
        self.code = code
