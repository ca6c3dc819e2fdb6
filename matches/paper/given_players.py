"""Who plays in given recordings, in a word or two: programs are not to pass for people."""

from collections.abc import Iterable, Sequence

from movingout.agents.data.dataset import has_person
from movingout.maps.suggestion import counted
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.episode import is_person
from movingout.recordings.groups import GroupedRecording, counted_people, people_of_groups, read_groups
from movingout.recordings.storage.listing import read_players

PEOPLE, SIMULATED, AGENTS = "people", "simulated participants", "agents"


def given_players(space: Workspace) -> str:
    """Of the lists that have been made; empty where scripted people recorded, or nothing has been listed."""
    if not space.given:
        return ""
    lists = [path for path in map(space.listing, ("c1", "c2")) if path.exists()]
    return players_of(row for path in lists for row in read_groups(path))


def players_of(rows: Iterable[GroupedRecording]) -> str:
    """Agents only where nobody else played in any episode. Raises RecordingError for a file that cannot be read."""
    found = {_player(row) for row in rows}
    return " and ".join(name for name in (PEOPLE, SIMULATED) if name in found) or (AGENTS if found else "")


def counted_players(rows: Sequence[GroupedRecording]) -> str:
    """How many these are, as `4 participants` or `2 agents`. Raises RecordingError for a file that cannot be read."""
    agents = _agents(rows) if players_of(rows) == AGENTS else set()
    return counted(len(agents), "agent") if agents else counted_people(set().union(*people_of_groups(rows).values()))


def _agents(rows: Iterable[GroupedRecording]) -> set[str]:
    """The names of those that act, without whom they replay."""
    seats = (seat for row in rows for seat in read_players(row.path).seats)
    return {seat.name for seat in seats if seat.name and not is_person(seat.kind)}


def _player(row: GroupedRecording) -> str:
    if row.simulated:
        return SIMULATED
    return PEOPLE if has_person([seat.kind for seat in read_players(row.path).seats]) else AGENTS
