"""A recorded seat to be played again as somebody's partner: the classic fixed-partner condition."""

from dataclasses import dataclass
from pathlib import Path

from maps import MapSpec
from maps.spec import SEAT_COLOURS
from recordings.errors import RecordingError
from recordings.reader import read_episode
from world.state import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Ghost:
    """What one seat did in one episode."""

    name: str  # of who played then
    map: MapSpec
    seat: int
    actions: Floats  # (T, 3) world actions; row t is for the step after t steps


def read_ghost(text: str) -> Ghost:
    """The ghost of `FILE#red` or `FILE#blue`. RecordingError says what is wrong with either part."""
    file, _, colour = text.rpartition("#")
    if not file or colour not in SEAT_COLOURS:
        raise RecordingError(f"a ghost is written FILE#blue or FILE#red, not {text!r}")
    episode = read_episode(Path(file))
    seat = SEAT_COLOURS.index(colour)
    return Ghost(episode.header.seats[seat].name, episode.header.map, seat, episode.actions[:, seat])
