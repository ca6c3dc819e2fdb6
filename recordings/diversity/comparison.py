"""Populations compared in their diversity: per map and over maps, from equally many episodes of each."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import Any, Literal, get_args

import numpy as np

from movingout.recordings.diversity.episodes import ALL, PathEpisode, Populations, by_map
from movingout.recordings.diversity.measures import Diversity, DiversityOptions, PathSet

Counts = Literal["equal", "all"]
COUNTS: tuple[Counts, ...] = get_args(Counts)
LEAST = 3  # episodes: two have one distance, which has no variance
MEASURES = ("dtw_mean", "dtw_variance", "entropy", "coverage")


@dataclass(frozen=True, slots=True)
class Sampling:
    """How many episodes of each population are measured."""

    counts: Counts = "equal"  # equal: as many as the smallest population has on that map, drawn `draws` times
    draws: int = 10
    seed: int = 0


@dataclass(frozen=True, slots=True)
class MapDiversity:
    """A population on one map."""

    map: str
    population: str
    episodes: int
    distinct: int  # of these; four maps give a deterministic pair the same episode for every seed
    drawn: int  # episodes that were measured at once; 0 when there are too few
    value: Diversity | None
    error: Diversity | None  # standard errors, by the jackknife over distinct episodes

    def to_json(self) -> dict[str, Any]:
        return {
            "map": self.map,
            "population": self.population,
            "episodes": self.episodes,
            "distinct": self.distinct,
            "drawn": self.drawn,
            **named(self.value),
            **{f"{name}_stderr": number for name, number in named(self.error).items()},
        }


@dataclass(frozen=True, slots=True)
class PopulationDiversity:
    """A population over the maps on which every population can be measured."""

    population: str
    maps: int
    episodes: int
    distinct: int
    value: Diversity | None  # mean over maps
    error: Diversity | None  # of that mean: root of the summed squares, over the number of maps

    def to_json(self) -> dict[str, Any]:
        return {
            "population": self.population,
            "maps": self.maps,
            "episodes": self.episodes,
            "distinct": self.distinct,
            **named(self.value),
            **{f"{name}_stderr": number for name, number in named(self.error).items()},
        }


def named(values: Diversity | None) -> dict[str, float | None]:
    """The four measures by name, None for all of them, or for one (NaN), where there is nothing."""
    numbers: Sequence[float] = astuple(values) if values is not None else [math.nan] * len(MEASURES)
    return {name: None if math.isnan(number) else number for name, number in zip(MEASURES, numbers, strict=True)}


def compared(groups: Populations, options: DiversityOptions, sampling: Sampling) -> list[MapDiversity]:
    """Every population on every map that it played, map by map."""
    everything = groups.get(ALL) or [episode for group in groups.values() for episode in group]
    rows: list[MapDiversity] = []
    for spec, there in by_map(everything):
        number = {id(episode): place for place, episode in enumerate(there)}
        paths = PathSet([episode.path for episode in there], options)
        members = {name: _members(group, number) for name, group in groups.items()}
        rows += _on_map(spec.name, paths, {name: index for name, index in members.items() if index}, sampling)
    return rows


def over_maps(rows: Sequence[MapDiversity]) -> list[PopulationDiversity]:
    """Means over the maps on which every population has a value, so that all rows are about the same maps."""
    names = list(dict.fromkeys(row.population for row in rows))
    measured = {(row.map, row.population): row for row in rows if row.value is not None}
    maps = [one for one in dict.fromkeys(row.map for row in rows) if all((one, name) in measured for name in names)]
    return [_over_maps(name, [measured[one, name] for one in maps]) for name in names]


def mean_over_maps(maps: Sequence[tuple[Diversity, Diversity | None]]) -> tuple[Diversity | None, Diversity | None]:
    """The mean of the values of maps and its standard error, None where one of them has none."""
    errors = [astuple(error) for _, error in maps if error is not None]
    squares = np.square(errors).sum(axis=0)
    of_mean = Diversity(*(np.sqrt(squares) / len(errors)).tolist()) if errors and len(errors) == len(maps) else None
    return _mean([value for value, _ in maps]), of_mean


def _members(group: Sequence[PathEpisode], number: Mapping[int, int]) -> list[int]:
    return [number[id(episode)] for episode in group if id(episode) in number]


def _on_map(spec: str, paths: PathSet, members: Mapping[str, list[int]], sampling: Sampling) -> list[MapDiversity]:
    enough = [len(index) for index in members.values() if len(index) >= LEAST]
    size = min(enough, default=0) if sampling.counts == "equal" else 0
    return [measured(spec, name, paths, index, size, sampling) for name, index in members.items()]


def measured(spec: str, name: str, paths: PathSet, index: list[int], size: int, sampling: Sampling) -> MapDiversity:
    """One population on one map, from draws of `size` episodes; 0 takes all of them."""
    distinct = paths.distinct(index)
    if len(index) < LEAST:
        return MapDiversity(spec, name, len(index), distinct, 0, None, None)
    draws = [index]
    if 0 < size < len(index):
        random = np.random.default_rng(sampling.seed)
        draws = [sorted(random.choice(index, size, replace=False).tolist()) for _ in range(sampling.draws)]
    values = [paths.diversity(draw) for draw in draws]
    errors = [error for error in map(paths.standard_errors, draws) if error is not None]
    return MapDiversity(spec, name, len(index), distinct, len(draws[0]), _mean(values), _mean(errors))


def _mean(values: Sequence[Diversity]) -> Diversity | None:
    """Of each measure over those that have it (not NaN)."""
    if not values:
        return None
    columns = np.array([astuple(value) for value in values]).T
    there = [column[~np.isnan(column)] for column in columns]
    return Diversity(*(float(column.mean()) if len(column) else math.nan for column in there))


def _over_maps(name: str, rows: Sequence[MapDiversity]) -> PopulationDiversity:
    there = [(row.value, row.error) for row in rows if row.value is not None]
    counts = sum(row.episodes for row in rows), sum(row.distinct for row in rows)
    return PopulationDiversity(name, len(rows), *counts, *mean_over_maps(there))
