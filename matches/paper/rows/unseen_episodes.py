"""Episodes in which the parts of BASS are measured: of people whom the agent has not learned from, pair by pair."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice, zip_longest
from pathlib import Path
from typing import TypeVar

from movingout.agents.data.dataset import Trajectory, read_trajectories
from movingout.agents.data.held_out import held_out_episodes
from movingout.matches.paper.workspace import GROUPS, Workspace
from movingout.recordings.groups import GroupedRecording, people_of_groups, read_groups

EPISODES = 2  # per map
_Value = TypeVar("_Value")


def unseen_episodes(challenge: int, space: Workspace) -> list[Trajectory]:
    """In Challenge 1 of group b; in Challenge 2, on the maps that agents are evaluated on."""
    if challenge == 2 and space.evaluation == "held-out":
        return held_out_episodes(2, space.budget.ticks, space.workers)
    rows = read_groups(space.listing("c1"))
    if challenge == 1:
        rows = [row for row in rows if row.group == GROUPS["b"]]
        return read_trajectories(list(pairs_in_turn(rows)))
    learned_from = set[str]().union(*people_of_groups(read_groups(space.listing("c2"))).values())
    return read_trajectories(list(pairs_in_turn(of_others(rows, learned_from))))


def of_others(rows: Sequence[GroupedRecording], people: set[str]) -> list[GroupedRecording]:
    """Those without these people; on a map of which these people have all, all."""
    others = [row for row in rows if people.isdisjoint(row.people)]
    maps = {row.map for row in others}
    return others + [row for row in rows if row.map not in maps]


def pairs_in_turn(rows: Iterable[GroupedRecording]) -> Iterator[Path]:
    """`EPISODES` of each map, by its pairs in turn: the next map begins with the pair whose turn it is."""
    maps: dict[str, dict[tuple[str, ...], list[Path]]] = defaultdict(lambda: defaultdict(list))
    for row in rows:
        maps[row.map][tuple(sorted(row.people))].append(row.path)
    for number, name in enumerate(sorted(maps)):
        pairs = [sorted(paths) for _, paths in sorted(maps[name].items())]
        # once every pair had its turn, their next episodes: in those they may have changed seats
        rounds, first = divmod(EPISODES * number, len(pairs))
        turns = [_from(paths, rounds) for paths in _from(pairs, first)]
        interleaved = (path for turn in zip_longest(*turns) for path in turn if path is not None)
        yield from islice(interleaved, EPISODES)


def _from(values: Sequence[_Value], first: int) -> list[_Value]:
    """The same values, beginning with another one."""
    first %= len(values)
    return [*values[first:], *values[:first]]
