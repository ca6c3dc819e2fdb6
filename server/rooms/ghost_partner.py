"""Recorded seats as partners in live rooms: which map such a room plays, and as which agent the seat is taken.

A ghost comes from the server's own recordings, by episode id, or from the file that the operator named as partner.
"""

from typing import NamedTuple, get_args

import msgspec

from movingout.maps import MapSpec, is_shipped, load_map
from movingout.maps.errors import MovingOutError
from movingout.maps.randomize import Split, randomize
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.recorded_seat import GHOST, ghost_of, read_recorded_seat
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig


class GhostError(MovingOutError):
    """The requested room does not fit the map or seat of its ghost."""


class GhostSeat(NamedTuple):
    """One ghost, and the map on which its actions make sense."""

    ghost: str  # FILE#red
    recorded_as: str  # ghost:EPISODE#red
    player: str  # who played then, empty if nobody knows
    seat: int
    map: str
    challenge2_seed: int | None  # None for the map as designed
    split: Split
    own: MapSpec | None  # the recorded map, where this server does not have just that

    def seat_at(self, index: int) -> Seat:
        """The ghost's seat. Raises GhostError for the other one."""
        if index != self.seat:
            raise GhostError(f"This ghost was recorded in the {SEAT_COLOURS[self.seat]} seat; give it that seat.")
        agent_id = f"{GHOST}:{self.ghost}"
        return Seat(index, GHOST, agent_id, name=self.player, alias=self.recorded_as)


def ghost_seat(ghost: str) -> GhostSeat:
    """The seat of `FILE#red`, in a tenth of a second. RecordingError when it cannot be played on this server."""
    recorded = read_recorded_seat(ghost)
    seed, split, own = _origin(recorded.map, recorded.seed)
    return GhostSeat(
        ghost=ghost, recorded_as=ghost_of(recorded.episode_id, recorded.seat), player=recorded.name,
        seat=recorded.seat, map=recorded.map.name, challenge2_seed=seed, split=split, own=own,
    )  # fmt: skip


def ghost_config(wanted: RoomConfig, ghosts: list[GhostSeat]) -> RoomConfig:
    """The requested room on exactly the map of its ghosts. Raises GhostError when they contradict each other."""
    if not ghosts:
        return wanted
    first = ghosts[0]
    if any(each[4:] != first[4:] for each in ghosts):
        raise GhostError("These two ghosts were recorded on different maps; take both from one map.")
    if wanted.maps != (first.map,) or wanted.challenge2_seed not in (None, first.challenge2_seed):
        raise GhostError(f"This ghost was recorded on {first.map}; choose that map alone, without shuffled items.")
    return msgspec.structs.replace(wanted, challenge2_seed=first.challenge2_seed, split=first.split)


def _origin(recorded: MapSpec, seed: int) -> tuple[int | None, Split, MapSpec | None]:
    """How this server makes the recorded map: as designed (None), or randomised with the seed.

    A map of somebody's own, or of another version, is taken from the recording as it was played.
    """
    if is_shipped(recorded.name):
        designed = load_map(recorded.name)
        if recorded == designed:
            return None, "train", None
        for split in get_args(Split):
            if recorded.variant == f"challenge2-{split}-{seed}" and recorded == randomize(designed, seed, split):
                return seed, split, None
    return None, "train", recorded
