"""Rows of how many people and episodes agents learn from: as the biggest budget has, or as were given."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from movingout.maps import map_names
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import DefinedCell, Found
from movingout.matches.paper.data_sets import EXPERTS
from movingout.matches.paper.entry import RowCells
from movingout.matches.paper.given_players import AGENTS, counted_players, players_of
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import GroupedRecording, people_of_groups, read_groups

SIZES = (
    "Sizes are those of the budget `full`, for scripted people; smaller budgets have fewer. With --data they are "
    "counted in the recordings that tables learn from, and not where those of a challenge cannot be learned from."
)
_Count = Callable[[Sequence[GroupedRecording]], float | str]


@dataclass(frozen=True, slots=True)
class SizeCell(DefinedCell):
    """A size of the scripted data; of given recordings, that of their list."""

    challenge: int = 1
    count: _Count = len

    def found(self, space: Workspace) -> Found | None:
        if not space.given:
            return Found(None, defined=self.value)
        listing = space.listing(f"c{self.challenge}")
        return Found(None, defined=self.count(read_groups(listing))) if listing.exists() else None


def _people(rows: Sequence[GroupedRecording]) -> float | str:
    """In words where they are agents, or some have no name."""
    found = set[str]().union(*people_of_groups(rows).values())
    return counted_players(rows) if "" in found or players_of(rows) == AGENTS else len(found)


def _per_pair_and_map(rows: Sequence[GroupedRecording]) -> float:
    return _share(rows, len({(frozenset(row.people), row.map) for row in rows}))


def _per_map(rows: Sequence[GroupedRecording]) -> float:
    return _share(rows, len({row.map for row in rows}))


def _share(rows: Sequence[GroupedRecording], number: int) -> float:
    return round(len(rows) / max(number, 1), 2)


def _size(value: int, challenge: int, count: _Count) -> RowCells:
    return lambda column: SizeCell(value, challenge=challenge, count=count)


_FULL, _MAPS = BUDGETS["full"], len(map_names())
DATA_ROWS: Mapping[tuple[str, str], RowCells] = {
    ("Challenge 1", "Participants"): _size(2 * _FULL.people, 1, _people),
    ("Challenge 1", "Episodes per pair and map"): _size(_FULL.episodes, 1, _per_pair_and_map),
    ("Challenge 1", "Episodes"): _size(_MAPS * _FULL.people * _FULL.episodes, 1, len),  # two populations, in pairs
    ("Challenge 2", "Participants"): _size(EXPERTS, 2, _people),
    ("Challenge 2", "Episodes per map"): _size(_FULL.variants, 2, _per_map),
    ("Challenge 2", "Episodes"): _size(_MAPS * _FULL.variants, 2, len),
}
