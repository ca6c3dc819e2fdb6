"""Whether a map can be played to the end in time: a pair of scripted experts delivers everything on it, or does not."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from movingout.agents.catalogue import load_agent
from movingout.agents.data.calls import results_of
from movingout.agents.data.rollout import rollout
from movingout.maps import MapSpec, load_map
from movingout.maps.errors import MapError
from movingout.maps.files.output_file import check_output, write_output
from movingout.maps.generated.names import MODE_WORDS, SPLITS, Split, generated_name, read_name
from movingout.maps.generated.proved import read_table
from movingout.maps.spec import Mode
from movingout.world.constants import LIMIT_TICKS
from movingout.world.scoring import delivered_items

PAIR = "scripted"
_BATCH = 4  # seeds of a mode that are tried at a time, for each worker


def ticks_to_deliver(spec: MapSpec, limit: int = LIMIT_TICKS) -> int | None:
    """After how many ticks the pair has delivered everything, None if it has not within the limit.

    The same on every machine with the pinned engine: the pair has no randomness but its seed, which is 0.
    """
    ticks, last = 0, None
    for step in rollout(spec, (load_agent(PAIR), load_agent(PAIR)), seed=0, ticks=limit):
        ticks, last = step.after.tick, step.after
    done = last is not None and bool(delivered_items(spec, last.item_poses).all())
    return ticks if done else None


def prove(split: Split, path: Path, count: int, workers: int, ray: str = "") -> Iterator[tuple[str, int | None]]:
    """Try the seeds of a split until the file names `count` maps of each mode; yields each map tried and its ticks.

    It is played by `workers` processes, or on the Ray cluster at an address, which has so many processors. What the
    file has is kept, the search goes on behind it, and the file is written after every few seeds, so that the command
    can be stopped and repeated. Raises MapError for a file with maps of another split, or, before anything is played,
    for one that cannot be written.
    """
    table = read_table(path)
    if strangers := [name for name in table if read_name(name)[1] not in SPLITS[split]]:
        raise MapError(f"{path} has {strangers[0]}, which is not of generated:{split}; choose another file")
    check_output(path)  # now rather than after the first maps
    behind = {mode: _first_untried(split, mode, table) for mode in MODE_WORDS}
    while modes := [mode for mode in MODE_WORDS if _count(mode, table) < count]:
        names = []
        for mode in modes:
            seeds = range(behind[mode], behind[mode] + _BATCH * workers)
            names += [generated_name(mode, seed) for seed in seeds if seed in SPLITS[split]]
            behind[mode] = seeds.stop
        if not names:
            raise MapError(f"all seeds of generated:{split} have been tried")
        for name, ticks in _results(names, workers, ray):
            if ticks is not None and _count(read_name(name)[0], table) < count:
                table[name] = ticks
            yield name, ticks
        _write(path, table)


def maps_per_mode(path: Path) -> dict[str, int]:
    """How many maps of each mode a file names. Raises MapError."""
    table = read_table(path)
    return {mode: _count(mode, table) for mode in MODE_WORDS}


def _first_untried(split: Split, mode: Mode, table: dict[str, int]) -> int:
    seeds = [read_name(name)[1] for name in table if read_name(name)[0] == mode]
    return max(seeds, default=SPLITS[split].start - 1) + 1


def _count(mode: Mode, table: dict[str, int]) -> int:
    return sum(read_name(name)[0] == mode for name in table)


def _results(names: Sequence[str], workers: int, ray: str) -> list[tuple[str, int | None]]:
    """In the order of the names, so that a list does not depend on who was faster."""
    found = dict(results_of([partial(_ticks, name) for name in names], workers, ray))
    return [(name, found[name]) for name in names]


def _ticks(name: str) -> tuple[str, int | None]:
    return name, ticks_to_deliver(load_map(name))


def _write(path: Path, table: dict[str, int]) -> None:
    write_output(path, "".join(f"{name} {ticks}\n" for name, ticks in table.items()).encode())
