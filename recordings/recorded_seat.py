"""What one seat did in a recording, to be replayed as a fixed partner; `ghost:FILE#red` names one."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from movingout.maps import MapSpec
from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import read_players
from movingout.world.state import Floats

GHOST: Final = "ghost"  # ghost:FILE#red; never offered in a list, since it names a file of this machine


@dataclass(frozen=True, slots=True, eq=False)
class RecordedSeat:
    """What one seat did in one episode."""

    episode_id: str
    name: str  # of who played then
    map: MapSpec
    seat: int
    seed: int
    limit_ticks: int  # of that episode, 0 for none
    actions: Floats  # (T, 3) world actions; row t is for the step after t steps


def is_ghost(agent_id: str) -> bool:
    return agent_id.startswith(f"{GHOST}:")


def read_recorded_seat(text: str) -> RecordedSeat:
    """The seat that `FILE#red` or `FILE#blue` names. RecordingError says what is wrong with either part."""
    file, seat = split_ghost(text)
    episode = read_episode(file)
    header = episode.header
    return RecordedSeat(
        header.episode_id, header.seats[seat].name, header.map, seat, header.seed, header.limit_ticks,
        episode.actions[:, seat],
    )  # fmt: skip


def split_ghost(text: str) -> tuple[Path, int]:
    """File and seat of `FILE#red`. Raises RecordingError."""
    file, _, colour = text.rpartition("#")
    if not file or colour not in SEAT_COLOURS:
        raise RecordingError(f"a recorded seat is written FILE#blue or FILE#red, not {text!r}")
    return Path(file), SEAT_COLOURS.index(colour)


def ghost_name(agent_id: str) -> str:
    """How `ghost:FILE#red` is named in recordings: `ghost:EPISODE#red`, without a folder of this machine.

    The episode is that of the file, whatever it is called; its name where it cannot be read.
    """
    file, seat = split_ghost(agent_id.removeprefix(f"{GHOST}:"))
    try:
        episode_id = read_players(file).episode_id
    except RecordingError:
        episode_id = file.name.partition(SUFFIX)[0]
    return ghost_of(episode_id, seat)


def ghost_of(episode_id: str, seat: int) -> str:
    """How a seat of an episode is named in recordings."""
    return f"{GHOST}:{episode_id}#{SEAT_COLOURS[seat]}"
