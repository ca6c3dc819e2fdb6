"""Plays one pair, a list of matches, or a whole grid into a results folder: the functions to call from a notebook."""

import json
import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from movingout.agents.llm.model_id import outrun_cautions
from movingout.agents.map_limits import check_map_seen
from movingout.maps import load_map
from movingout.maps.commands.map_cautions import map_cautions
from movingout.maps.library import is_generated_or_shipped
from movingout.maps.selection import selected_maps
from movingout.matches.errors import MatchError
from movingout.matches.execution.agent_objects import AgentLike, AgentObjects
from movingout.matches.execution.dispatch import WorkerPool, dispatch
from movingout.matches.execution.local_workers import LocalWorkerPool
from movingout.matches.execution.lockstep import AGENT_LIMIT_S, Lockstep
from movingout.matches.execution.recorder import recorded_before, superseded
from movingout.matches.experiment.grid import Grid, played_grid, read_grid
from movingout.matches.experiment.plan import (
    PlannedMatch,
    agent_for_seed,
    load_for_workers,
    matches_of,
    missing_agents,
    planned_matches,
)
from movingout.matches.match import Challenge, Match, MatchResult, check_numbers
from movingout.matches.results.other_code import MIXED, is_mixed, of_other_code, with_code
from movingout.matches.results.provenance import named_by, provenance_of
from movingout.matches.results.results_folder import (
    Shard,
    add_metrics,
    check_named,
    open_folder,
    order_of,
    read_head,
    read_results,
    to_play,
    write_whole,
)
from movingout.matches.results.table import ResultRow, markdown, rows_of
from movingout.matches.results.unanswered import unanswered
from movingout.world.constants import LIMIT_TICKS

OnProgress = Callable[[int, int], None]
"""Called with the number of finished matches and of all."""
OnAgain = Callable[[int], None]
"""Called with the number of matches that failed before and are played again."""
OnUnrecorded = Callable[[int], None]
"""Called with the number of matches that are to be recorded and were played before without a recording."""
OnOtherCode = Callable[[int], None]
"""Called with the number of matches that are kept and were played by other code of this project than is here."""
OnCaution = Callable[[str], None]
"""Called, before anything is played, with each sentence about a map file that cannot be played as it should, or about
a language model that does not wait."""
OnResult = Callable[[MatchResult], None]
"""Called with each result as it arrives."""
WorkerPoolFactory = Callable[[int, float, Path | None], WorkerPool]
"""Called with (workers, agent_limit_s, record); returns the pool."""


def no_op(*_: object) -> None:
    """Shows no progress and does nothing with a result."""


def warn_caller(sentence: str) -> None:
    """Warn who called the function that says the sentence."""
    warnings.warn(sentence, stacklevel=3)


def played_again(failed: int) -> str:
    """`2 matches failed before: played again`"""
    return f"{failed:,} match{'es' * (failed != 1)} failed before: played again"


def played_unrecorded(matches: int) -> str:
    """`2 matches were played before without a recording; use another --out to record them`"""
    what = f"{matches:,} match{'es were' if matches != 1 else ' was'}"
    return f"{what} played before without a recording; use another --out to record {'them' if matches != 1 else 'it'}"


@dataclass(frozen=True, slots=True)
class GridRun:
    """A results folder and the results in it so far."""

    folder: Path
    grid: Grid
    plan: list[PlannedMatch]
    results: dict[Match, MatchResult]

    def __repr__(self) -> str:
        """`<GridRun mine: 8 matches in data/matches/mine, 0 failed, 0 missing>`"""
        played = f"{len(self.results)} matches in {self.folder}"
        return f"<GridRun {self.grid.name}: {played}, {len(self.failures)} failed, {self.missing} missing>"

    @property
    def rows(self) -> list[ResultRow]:
        return rows_of(self.plan, self.results)

    @property
    def failures(self) -> list[MatchResult]:
        return [result for result in self.results.values() if result.ending == "failed"]

    @property
    def missing(self) -> int:
        """How many matches have not been played yet."""
        return len(matches_of(self.plan)) - len(self.results)

    @property
    def mixed_code(self) -> bool:
        """Whether some matches were played by other code of this project than others."""
        return is_mixed(self.results.values())

    def to_json(self) -> dict[str, Any]:
        return {
            "grid": self.grid.name,
            "sha256": self.grid.sha256,
            "mixed_code": self.mixed_code,
            "matches": len(self.results),
            "missing": self.missing,
            "unanswered": found._asdict() if (found := unanswered(self.results.values())) else None,
            "results": [row.to_json() for row in self.rows],
            "failures": [result.to_json() for result in self.failures],
        }


def play(
    blue: AgentLike,
    red: AgentLike,
    map: str | Path = "HandOff",
    *,
    episodes: int = 1,
    seed: int = 0,
    challenge: Challenge = 1,
    ticks: int = LIMIT_TICKS,
    workers: int | None = None,
    record: Path | str | None = None,
) -> list[MatchResult]:
    """Let two agents play matches in worker processes; returns the results in the order of maps and seeds.

        results = movingout.play("scripted", "idle", "HandOff", episodes=5)
        print([result.metrics.tcr for result in results])

    `blue`, `red`: agent ids, such as "scripted", "person:name=A03", "bass@all" or "my_module:MyAgent"; a group such as
    "people:A", whose members play in turn; or agents as objects, a class or an instance, which play in this process,
    one match after the other.
    `map`: a name, the path of a map file, "all" for the paper's twelve, or another selection (`maps.selection`).
    `episodes`: matches per map, with the seeds `seed`, `seed` + 1, ...
    `challenge`: 1 plays the maps as designed; 2 varies the items' sizes and shapes by the seed.
    `ticks`: limit of a match; a tick is 0.1 s.
    `workers`: processes; default: one per processor core.
    `record`: a folder that gets a recording of each match. Recordings that it has already stay; a warning says so.

    An agent that raises an exception or exceeds its time limit ends its match with `ending` "failed" and a reason in
    `failure`; a warning says so. Others say what is wrong with a map file, and which language models do not wait.
    Raises MovingOutError, before anything is played, for an unknown agent or map.
    """
    check_numbers(episodes, seed, ticks, challenge)
    seed, ticks, challenge = int(seed), int(ticks), 2 if challenge == 2 else 1  # numpy's integers are no JSON
    maps, objects = selected_maps(map), AgentObjects(blue, red)
    one, other = objects.name(blue), objects.name(red)
    matches = [
        Match(name, agent_for_seed(one, each), agent_for_seed(other, each, one == other), each, challenge, ticks)
        for name in maps
        for each in range(seed, seed + episodes)
    ]
    for sentence in _cautions(matches):
        warn_caller(sentence)
    folder = None if record is None else Path(record)
    results = _play_here(matches, objects, folder) if objects else play_matches(matches, workers=workers, record=folder)
    if failed := [result for result in results if result.ending == "failed"]:
        warnings.warn(f"{len(failed)} of {len(results)} matches failed: {failed[0].failure}", stacklevel=2)
    if note := recorded_before(results):
        warnings.warn(note, stacklevel=2)
    return results


def _play_here(matches: Sequence[Match], objects: AgentObjects, record: Path | None) -> list[MatchResult]:
    """Play one match after the other in this process, since an instance plays one at a time."""
    for agent_id in dict.fromkeys(matches[0].seats if matches else ()):
        objects.load(agent_id)
    for match in matches:
        match.world_map()
    if record is not None:
        make_folder(record)
    lockstep = Lockstep(record=record, batch_size=1, load=objects.load)
    found = {result.match: result for result in lockstep.play(dict.fromkeys(matches))}
    return [found[match] for match in matches]


def play_matches(
    matches: Sequence[Match],
    *,
    workers: int | None = None,
    record: Path | None = None,
    agent_limit_s: float = AGENT_LIMIT_S,
    pool: WorkerPoolFactory = LocalWorkerPool,
    progress: OnProgress = no_op,
    on_result: OnResult = no_op,
) -> list[MatchResult]:
    """Play matches; returns the results in the same order. Matches that occur twice are played once.

    `pool` makes the workers (default: processes of this machine). Raises MovingOutError before anything is played.
    """
    for agent_id in sorted({agent_id for match in matches for agent_id in match.seats}):
        load_for_workers(agent_id)
    for match in matches:
        match.world_map()
    check_own_maps(matches)
    if record is not None:
        make_folder(record)
    found: dict[Match, MatchResult] = {}
    todo = list(dict.fromkeys(matches))
    size = _workers(workers, len(todo))
    with closing(dispatch(pool(size, agent_limit_s, record), todo)) as results:
        for result in results:
            found[result.match] = result
            on_result(result)
            progress(len(found), len(todo))
    return [found[match] for match in matches]


def run_grid(
    grid: Grid | Path | str,
    out: Path | str,
    *,
    workers: int | None = None,
    record: bool = False,
    shard: tuple[int, int] = (0, 1),
    pool: WorkerPoolFactory = LocalWorkerPool,
    progress: OnProgress = no_op,
    again: OnAgain = no_op,
    unrecorded: OnUnrecorded = no_op,
    other_code: OnOtherCode = no_op,
    caution: OnCaution = warn_caller,
) -> GridRun:
    """Play the matches of a grid that the folder `out` does not hold yet; returns all results in it.

        run = movingout.run_grid("grid.yaml", "data/matches/mine")
        for row in run.rows:
            print(row.agent, row.partner, row.map, len(row.results))

    Each result is on disk as soon as its match ends, so a run that was stopped continues when called again.
    Matches that failed are then played again.

    `grid`: a `Grid` or the path of a YAML file (docs/matches.md).
    `record`: also write a recording of each match that is played, into `out`/recordings.
    `shard`: (i, n) plays every n-th match from the i-th on, for arrays of jobs that share a folder.
    `pool`: makes the workers (default: processes of this machine; `ray_worker_pool` for a cluster).

    Raises MatchError when the grid is invalid, an agent is missing, or the folder holds another grid, or this
    one as played with other weights, code of agents or map files; AgentError for a map with more than an agent sees;
    MapError for one without a variant that challenge 2 asks for.
    """
    if not isinstance(grid, Grid | str | os.PathLike):
        raise MatchError(f"a grid is a Grid or the path of a YAML file, not {grid!r:.80}")
    grid, folder = grid if isinstance(grid, Grid) else read_grid(Path(grid)), Path(out)
    missing = missing_agents(grid)
    if missing:
        raise MatchError(f"grid {grid.name!r} needs agents that are not here: {'; '.join(missing)}")
    index, count = shard
    if not 0 <= index < count:
        raise MatchError(f"shard {index}/{count}: the first number counts from 0 to {count - 1}")
    plan = planned_matches(grid, order_of(folder))
    matches = matches_of(plan)[index::count]
    for sentence in _cautions(matches_of(plan)):
        caution(sentence)
    check_own_maps(matches_of(plan))
    check_variants(to_play(matches, read_results(folder)))
    make_folder(folder)
    provenance = provenance_of(grid)
    open_folder(folder, grid, provenance)
    with Shard(folder, index, count) as file:
        finished = read_results(folder)
        todo = to_play(matches, finished)
        if failed := sum(match.id in finished for match in todo):
            again(failed)
        if todo and (other := of_other_code(finished[match.id] for match in matches if match.id in finished)):
            other_code(other)
        recordings = folder / "recordings" if record else None
        if recordings is not None:
            make_folder(recordings)
            if lacking := _unrecorded(matches, finished):
                unrecorded(lacking)
        done = len(matches) - len(todo)
        progress(done, len(matches))
        if todo:
            add_metrics(folder, provenance)
            workers_here = pool(_workers(workers, len(todo)), grid.agent_limit_s, recordings)
            with closing(dispatch(workers_here, todo)) as results:
                for result in _kept(results, folder):
                    file.append([result])
                    _replace_earlier(folder, result)
                    done += 1
                    progress(done, len(matches))
    return finish(folder, grid, plan)


def _cautions(matches: Sequence[Match]) -> list[str]:
    """What is to be said of their maps, and of language models that they outrun."""
    seated = (agent_id for match in matches for agent_id in match.seats)
    return [*map_cautions(match.map for match in matches), *outrun_cautions(seated)]


def check_own_maps(matches: Sequence[Match]) -> None:
    """Raises AgentError for a map file with more than an agent sees, before anything is played on it."""
    seated_on = dict.fromkeys((agent_id, match.map) for match in matches for agent_id in match.seats)
    for agent_id, name in seated_on:
        if not is_generated_or_shipped(name):
            check_map_seen(agent_id, load_map(name), name)


def check_variants(matches: Sequence[Match]) -> None:
    """Raises MapError for a map without a playable variant for a seed, which would count as the agents' failure."""
    varied = {(match.map, match.seed, match.split): match for match in matches if match.challenge == 2}
    own = {name for name in {match.map for match in varied.values()} if not is_generated_or_shipped(name)}
    for match in varied.values():
        if match.map in own:  # others have one for each seed that was tried; to make one takes 10 ms
            match.world_map()


def finish(folder: Path, grid: Grid, plan: list[PlannedMatch]) -> GridRun:
    """Read all results of a folder and write the tables beside them."""
    found = {result.match: result for result in read_results(folder).values()}
    run = GridRun(folder, grid, plan, {match: found[match] for match in matches_of(plan) if match in found})
    write_whole(folder / "results.json", json.dumps(run.to_json(), indent=1) + "\n")
    note = f"\n{MIXED}\n" if run.mixed_code else ""
    write_whole(folder / "results.md", f"# {grid.name}\n\n{markdown(run.rows)}{note}")
    return run


def open_run(folder: Path | str) -> GridRun:
    """Read a results folder without playing. Raises MatchError when it is not one."""
    folder = Path(folder)
    head = read_head(folder)
    try:
        grid = played_grid(head["grid"])
    except ValidationError as error:
        said = "; ".join(str(fault["msg"]).removeprefix("Value error, ") for fault in error.errors()[:3])
        raise MatchError(f"the grid of {folder} can no longer be read: {said}") from error
    check_named(folder, head, named_by(grid))
    plan = planned_matches(grid, order_of(folder))
    found = {result.match: result for result in read_results(folder).values()}
    return GridRun(folder, grid, plan, {match: found[match] for match in matches_of(plan) if match in found})


def make_folder(folder: Path) -> None:
    """Make a folder unless it exists. Raises MatchError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MatchError(f"cannot make the folder {folder}: {error.strerror or error}") from error


def _kept(results: Iterator[MatchResult], folder: Path) -> Iterator[MatchResult]:
    """Results as they are kept: paths of recordings relative to the results folder, so that it can be moved."""
    for result in results:
        path = Path(result.recording)
        if result.recording and path.is_relative_to(folder.resolve()):
            result = replace(result, recording=str(path.relative_to(folder.resolve())))
        yield with_code(result)


def _unrecorded(matches: Sequence[Match], finished: Mapping[str, MatchResult]) -> int:
    """How many of these matches are not played again and have no recording."""
    todo = {match.id for match in to_play(matches, finished)}
    return sum(match.id not in todo and not finished[match.id].recording for match in matches)


def _replace_earlier(folder: Path, result: MatchResult) -> None:
    """Remove recordings of a match that had no result, or failed, now that it is played through with one of its own.

    A match that fails again keeps them: which of its results is read, another shard may say.
    """
    for path in superseded(folder / result.recording) if result.recording and result.ending != "failed" else ():
        with suppress(OSError):  # a file that stays is no reason to stop
            path.unlink(missing_ok=True)


def _workers(wanted: int | None, matches: int) -> int:
    if wanted is not None and wanted < 1:
        raise MatchError(f"at least 1 worker is needed, not {wanted}")
    return max(1, min(wanted or os.cpu_count() or 1, matches))
