"""Playing: one pair, a list of matches, a whole grid into a results folder. The functions a notebook calls."""

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from movingout.agents.catalogue import load_agent
from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.maps import map_names
from movingout.matches.errors import MatchError
from movingout.matches.execution.dispatch import Crew, dispatch
from movingout.matches.execution.local_workers import LocalCrew
from movingout.matches.execution.lockstep import AGENT_LIMIT_S
from movingout.matches.experiment.grid import Grid, read_grid
from movingout.matches.experiment.plan import Entry, entries, matches_of, missing_agents
from movingout.matches.match import Challenge, Match, MatchResult
from movingout.matches.results.results_folder import Shard, open_folder, read_head, read_results, write_whole
from movingout.matches.results.table import Row, markdown, rows_of
from movingout.world.constants import LIMIT_TICKS

Progress = Callable[[int, int], None]
"""Called with (finished, all) matches."""
Heed = Callable[[MatchResult], None]
"""Called with each result as it comes."""
CrewMaker = Callable[[int, float, Path | None], Crew]
"""(workers, agent_limit_s, record) -> Crew"""


def _silent(finished: int, count: int) -> None:
    """No progress shown."""


def _heedless(result: MatchResult) -> None:
    """Results are looked at when all are there."""


@dataclass(frozen=True, slots=True)
class GridRun:
    """A results folder and what it holds so far."""

    folder: Path
    grid: Grid
    plan: list[Entry]
    results: dict[Match, MatchResult]

    @property
    def rows(self) -> list[Row]:
        return rows_of(self.plan, self.results)

    @property
    def failures(self) -> list[MatchResult]:
        return [result for result in self.results.values() if result.ending == "failed"]

    @property
    def missing(self) -> int:
        """Matches not played yet."""
        return len(matches_of(self.plan)) - len(self.results)

    def to_json(self) -> dict[str, Any]:
        return {
            "grid": self.grid.name,
            "sha256": self.grid.sha256,
            "matches": len(self.results),
            "missing": self.missing,
            "results": [row.to_json() for row in self.rows],
            "failures": [result.to_json() for result in self.failures],
        }


def play(
    blue: str,
    red: str,
    map: str = "HandOff",
    *,
    episodes: int = 1,
    seed: int = 0,
    challenge: Challenge = 1,
    ticks: int = LIMIT_TICKS,
    workers: int | None = None,
    record: Path | str | None = None,
) -> list[MatchResult]:
    """Let two agents play `episodes` matches with the seeds `seed`, `seed` + 1, ...; `map` is a name, a path or "all".

    The results are in the order of maps and seeds. Raises MovingOutError for an unknown agent or map.
    """
    maps = map_names() if map == "all" else (map,)
    matches = [Match(name, blue, red, seed + k, challenge, ticks) for name in maps for k in range(episodes)]
    return play_matches(matches, workers=workers, record=None if record is None else Path(record))


def play_matches(
    matches: Sequence[Match],
    *,
    workers: int | None = None,
    record: Path | None = None,
    agent_limit_s: float = AGENT_LIMIT_S,
    crew: CrewMaker = LocalCrew,
    progress: Progress = _silent,
    heed: Heed = _heedless,
) -> list[MatchResult]:
    """The results of matches, in their order. Raises MovingOutError before anything is played."""
    for agent_id in sorted({agent_id for match in matches for agent_id in match.seats}):
        load_agent(agent_id)
    for match in matches:
        match.world_map()
    if record is not None:
        make_folder(record)
    found: dict[Match, MatchResult] = {}
    todo = list(dict.fromkeys(matches))
    size = _workers(workers, len(todo))
    with closing(dispatch(crew(size, agent_limit_s, record), todo)) as results:
        for result in results:
            found[result.match] = result
            heed(result)
            progress(len(found), len(todo))
    return [found[match] for match in matches]


def run_grid(
    grid: Grid | Path | str,
    out: Path | str,
    *,
    workers: int | None = None,
    record: bool = False,
    shard: tuple[int, int] = (0, 1),
    crew: CrewMaker = LocalCrew,
    progress: Progress = _silent,
) -> GridRun:
    """Play what is missing of a grid in the folder `out`; returns everything there.

    A killed run goes on where it was. `shard` (i, n): only each n-th match from the i-th (arrays of jobs).
    `crew` says where the workers are (default: processes of this machine). Raises MatchError in a sentence.
    """
    grid, folder = grid if isinstance(grid, Grid) else read_grid(Path(grid)), Path(out)
    missing = missing_agents(grid)
    if missing:
        raise MatchError(f"grid {grid.name!r} needs agents that are not here: {'; '.join(missing)}")
    index, count = shard
    if not 0 <= index < count:
        raise MatchError(f"shard {index}/{count}: the first number counts from 0 to {count - 1}")
    make_folder(folder)
    open_folder(folder, grid, _checkpoints(grid))
    plan = entries(grid)
    matches = matches_of(plan)[index::count]
    with Shard(folder, index, count) as file:
        finished = read_results(folder)
        todo = [match for match in matches if match.id not in finished]
        recordings = folder / "recordings" if record else None
        if recordings is not None:
            make_folder(recordings)
        done = len(matches) - len(todo)
        progress(done, len(matches))
        if todo:
            workers_here = crew(_workers(workers, len(todo)), grid.agent_limit_s, recordings)
            with closing(dispatch(workers_here, todo)) as results:
                for result in _relative(results, folder):
                    file.append([result])
                    done += 1
                    progress(done, len(matches))
    return finish(folder, grid, plan)


def finish(folder: Path, grid: Grid, plan: list[Entry]) -> GridRun:
    """Read all results and write the tables beside them."""
    found = {result.match: result for result in read_results(folder).values()}
    run = GridRun(folder, grid, plan, {match: found[match] for match in matches_of(plan) if match in found})
    write_whole(folder / "results.json", json.dumps(run.to_json(), indent=1) + "\n")
    write_whole(folder / "results.md", f"# {grid.name}\n\n{markdown(run.rows)}")
    return run


def open_run(folder: Path | str) -> GridRun:
    """What a results folder holds. Raises MatchError when it is none."""
    folder = Path(folder)
    grid = Grid.model_validate_json(json.dumps(read_head(folder)["grid"]))
    plan = entries(grid)
    found = {result.match: result for result in read_results(folder).values()}
    return GridRun(folder, grid, plan, {match: found[match] for match in matches_of(plan) if match in found})


def make_folder(folder: Path) -> None:
    """Make a folder where there is none. Raises MatchError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MatchError(f"cannot make the folder {folder}: {error.strerror or error}") from error


def _relative(results: Iterator[MatchResult], folder: Path) -> Iterator[MatchResult]:
    """Recordings named from the results folder on, so that the folder can be moved."""
    for result in results:
        path = Path(result.recording)
        if result.recording and path.is_relative_to(folder.resolve()):
            result = replace(result, recording=str(path.relative_to(folder.resolve())))
        yield result


def _checkpoints(grid: Grid) -> dict[str, str]:
    ids = {agent_id for entry in entries(grid) for agent_id in entry.match.seats}
    return {agent_id: sha for agent_id in sorted(ids) if (sha := fingerprint(agent_id))}


def _workers(wanted: int | None, matches: int) -> int:
    if wanted is not None and wanted < 1:
        raise MatchError(f"at least 1 worker is needed, not {wanted}")
    return max(1, min(wanted or os.cpu_count() or 1, matches))
