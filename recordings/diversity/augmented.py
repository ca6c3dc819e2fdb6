"""Populations with recombined paths beside the recorded ones, compared with what was recorded alone.

What recombines is given by the caller, as it takes what agents learn from.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from movingout.recordings.diversity.comparison import MapDiversity, Sampling, measured
from movingout.recordings.diversity.episodes import PathEpisode, Populations, by_map
from movingout.recordings.diversity.measures import DiversityOptions, PathSet
from movingout.recordings.episode import Episode
from movingout.world.estimates import Estimate
from movingout.world.state import Floats

T = TypeVar("T")
PATHS = 24  # at most, per map, or as many as were recorded there: all pairs of them are aligned


class AugmentedPopulation(NamedTuple):
    """What recombination makes of a population, in one way."""

    name: str  # of the way
    paths: dict[str, list[Floats]]  # per map, (T + 1, 4) each; none where nothing can be recombined
    valid: Estimate | None  # share of pieces that the engine confirms; None where there are none


class Recombination(NamedTuple):
    """How to recombine."""

    content: Callable[[Episode], Any]  # what it needs of an episode, as `PathEpisode.content`; can be pickled
    populations: Callable[[Sequence[PathEpisode], int, int], list[AugmentedPopulation]]  # given seed, pieces to try
    method: str  # sentences


class AugmentedSet(NamedTuple):
    """The paths of an augmented population that are measured."""

    recorded: str  # name of the population
    name: str  # and of the way
    paths: dict[str, list[Floats]]  # per map, recorded and recombined
    valid: Estimate


def evenly_chosen(values: Sequence[T], most: int) -> list[T]:
    """At most so many, evenly over their order."""
    size = min(most, len(values))
    return [values[number] for number in np.linspace(0, len(values) - 1, size).round().astype(int)]


def augmented_sets(
    groups: Populations, recombination: Recombination, seed: int, pieces: int
) -> tuple[list[AugmentedSet], list[str]]:
    """Every population with recombined paths beside the recorded ones, and sentences on what cannot be recombined."""
    sets, lacking = [], []
    for group, episodes in groups.items():
        recorded = {spec.name: [one.path for one in there] for spec, there in by_map(episodes)}
        for name, paths, valid in recombination.populations(episodes, seed, pieces):
            if valid is None:
                lacking.append(_nothing(f"{group}, {name}", recorded))
                continue
            mixed = {spec: _mixed(there, paths.get(spec, [])) for spec, there in recorded.items()}
            sets.append(AugmentedSet(group, f"{group}, {name}", mixed, valid))
            lacking += _alone(f"{group}, {name}", [spec for spec in recorded if spec not in paths])
    return sets, lacking


def with_augmented(
    rows: Sequence[MapDiversity], sets: Sequence[AugmentedSet], options: DiversityOptions, sampling: Sampling
) -> Iterator[MapDiversity]:
    """The rows, each followed by those of its population's sets: of as many paths, where counts are equal."""
    for row in rows:
        yield row
        for one in (one for one in sets if one.recorded == row.population):
            paths = PathSet(one.paths[row.map], options)
            index = list(range(len(paths.alike)))
            if row.value is None:
                yield MapDiversity(row.map, one.name, len(index), paths.distinct(), 0, None, None)
            else:
                size = row.drawn if sampling.counts == "equal" else 0
                yield measured(row.map, one.name, paths, index, size, sampling)


def _mixed(recorded: list[Floats], recombined: list[Floats]) -> list[Floats]:
    return evenly_chosen([*recorded, *recombined], max(PATHS, len(recorded)))


def _nothing(name: str, recorded: Mapping[str, Sequence[Floats]]) -> str:
    """Why a whole population is not there."""
    if all(len(paths) == 1 for paths in recorded.values()):
        return f"{name}: nothing can be recombined; that takes two episodes of a map, and there is one of each"
    return f"{name}: nothing can be recombined; no two episodes of a map have a matching stretch that agents learn from"


def _alone(name: str, maps: Sequence[str]) -> list[str]:
    return (
        [f"{name}: nothing was recombined on {', '.join(maps)}; what was recorded there stands alone"] if maps else []
    )
