"""How diverse the episodes of each challenge are, and what recombination adds (`agents.training.recombined_paths`).

Means over maps of the paper's four measures, with the jackknife's standard errors.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from movingout.agents.bass.recombination import LearnedPart, Matching
from movingout.agents.data.dataset import Trajectory, read_trajectories
from movingout.agents.data.diversity import path_of
from movingout.agents.training.recombined_paths import recombined_paths, valid_share, whole_parts
from movingout.maps.suggestion import counted
from movingout.matches.paper.cells import MeasuredCell, Measurement
from movingout.matches.paper.imitation import seat_choice
from movingout.matches.paper.workspace import Measured, Workspace
from movingout.recordings.diversity.augmented import PATHS, evenly_chosen
from movingout.recordings.diversity.comparison import LEAST, mean_over_maps, named
from movingout.recordings.diversity.measures import PathSet
from movingout.recordings.groups import listed_maps
from movingout.world.estimates import Estimate
from movingout.world.state import Floats


def diversity_cell(data: str, field: str) -> MeasuredCell:
    """A measure of the recorded episodes of a data set."""
    about = f"diversity of the episodes of {data}"
    perform = partial(_recorded, data)
    return MeasuredCell(Measurement(f"diversity-of-{data}", about, perform, data=(data,)), field, may_lack=True)


def equal_cell(data: str, field: str) -> MeasuredCell:
    """A measure of as many episodes per map as every population of the comparison has."""
    about = f"diversity of the episodes of {data}, equally many of each population"
    perform = partial(_equally_many, data)
    return MeasuredCell(
        Measurement(f"diversity-of-equal-{data}", about, perform, data=("c1", "c2")), field, may_lack=True
    )


def equal_sizes(space: Workspace) -> dict[str, int]:
    """Per map, how many episodes both challenges have; sets of other sizes are not alike in spread and entropy."""
    counts = [listed_maps(space.listing(data)) for data in ("c1", "c2")]
    return {name: min(number, counts[1][name], PATHS) for name, number in counts[0].items()}


def augmented_cell(matching: Matching, field: str) -> MeasuredCell:
    """A measure of the episodes of Challenge 1 with recombined ones, or the share of valid pieces."""
    about = f"diversity after recombination, {matching}"
    perform = partial(_augmented, matching)
    return MeasuredCell(Measurement(f"diversity-of-{matching}", about, perform, data=("c1",)), field, may_lack=True)


def recorded_maps(space: Workspace) -> list[str]:
    """A sentence where some map has too few episodes of Challenge 1 for diversity; once they have been listed."""
    listing = space.listing("c1")
    return _maps_with_enough(listed_maps(listing), "recorded") if listing.exists() else []


def equal_maps(space: Workspace) -> list[str]:
    """A sentence where some map has too few episodes of one challenge; once those of both have been listed."""
    listed = all(space.listing(data).exists() for data in ("c1", "c2"))
    return _maps_with_enough(equal_sizes(space), "of each population") if listed else []


def _maps_with_enough(episodes: Mapping[str, int], which: str) -> list[str]:
    enough = sum(number >= LEAST for number in episodes.values())
    said = f"{enough} of {counted(len(episodes), 'map')} {'has' if enough == 1 else 'have'} as many {which}"
    needed = f"Diversity needs {LEAST} episodes of a map, and leaves out others"
    return [f"{needed}; {said}."] if enough < len(episodes) else []


def learned_parts(trajectories: Sequence[Trajectory], space: Workspace) -> list[LearnedPart]:
    """The seats of whole episodes that agents of the tables learn from."""
    return whole_parts(trajectories, seat_choice((one.kinds for one in trajectories), space))


def _recorded(data: str, space: Workspace, training: int) -> Measured:
    paths = [(one.map.name, path_of(one)) for one in read_trajectories(space.episodes(data))]
    return diversity_over_maps(paths)


def _equally_many(data: str, space: Workspace, training: int) -> Measured:
    paths = [(one.map.name, path_of(one)) for one in read_trajectories(space.episodes(data))]
    return diversity_over_maps(paths, equal_sizes(space))


def _augmented(matching: Matching, space: Workspace, training: int) -> Measured:
    trajectories = read_trajectories(space.episodes("c1"))
    parts = learned_parts(trajectories, space)
    paths = [(one.map.name, path_of(one)) for one in trajectories]
    paths += recombined_paths(parts, len(trajectories), space.seed, matching)
    share = valid_share(parts, space.budget.states, space.seed, matching)
    return {**diversity_over_maps(paths), **({"valid_share": share} if share else {})}


def diversity_over_maps(paths: Sequence[tuple[str, Floats]], sizes: Mapping[str, int] | None = None) -> Measured:
    """The four measures, averaged over the maps that have enough paths; `sizes`: of so many per map."""
    sets = [PathSet(group) for group in _by_map(paths, sizes) if len(group) >= LEAST]
    value, error = mean_over_maps([(one.diversity(), one.standard_errors()) for one in sets])
    of_mean, count = named(error), sum(len(one.alike) for one in sets)
    return {name: Estimate(mean, of_mean[name], count) for name, mean in named(value).items() if mean is not None}


def _by_map(paths: Sequence[tuple[str, Floats]], sizes: Mapping[str, int] | None) -> Iterator[list[Floats]]:
    """The paths of each map, evenly chosen where there are more than wanted."""
    groups: defaultdict[str, list[Floats]] = defaultdict(list)
    for name, path in paths:
        groups[name].append(path)
    for name, group in groups.items():
        yield evenly_chosen(group, PATHS if sizes is None else sizes.get(name, 0))
