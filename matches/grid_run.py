"""Plays a grid into a results folder, as much of it as is not there yet, and reads such a folder."""

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from movingout.matches.callbacks import (
    OnAgain,
    OnCaution,
    OnOtherCode,
    OnProgress,
    OnUnrecorded,
    WorkerPoolFactory,
    no_op,
    warn_caller,
)
from movingout.matches.errors import MatchError
from movingout.matches.execution.dispatch import dispatch
from movingout.matches.execution.local_workers import LocalWorkerPool
from movingout.matches.execution.recorder import superseded
from movingout.matches.experiment.grid import Grid, played_grid, read_grid
from movingout.matches.experiment.plan import PlannedMatch, matches_of, missing_agents, planned_matches
from movingout.matches.match import Match, MatchResult
from movingout.matches.preparation import cautions, check_own_maps, check_variants, make_folder, worker_count
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

    `grid`: a `Grid`, the path of a YAML file (docs/matches.md) or the name of a shipped one, such as "idle-control".
    `record`: also write a recording of each match that is played, into `out`/recordings.
    `shard`: (i, n) plays every n-th match from the i-th on, for arrays of jobs that share a folder.
    `pool`: makes the workers (default: processes of this machine; `ray_worker_pool` for a cluster).

    Raises MatchError when the grid is invalid, an agent is missing, or the folder holds another grid, or this
    one as played with other weights, code of agents or map files; AgentError for a map with more than an agent sees;
    MapError for one without a variant that challenge 2 asks for.
    """
    if not isinstance(grid, Grid | str | os.PathLike):
        raise MatchError(f"a grid is a Grid, the path of a YAML file or a shipped grid's name, not {grid!r:.80}")
    grid, folder = grid if isinstance(grid, Grid) else read_grid(grid), Path(out)
    index, count = shard
    _check(grid, index, count)
    plan = planned_matches(grid, order_of(folder))
    matches = matches_of(plan)[index::count]
    for sentence in cautions(matches_of(plan)):
        caution(sentence)
    check_own_maps(matches_of(plan))
    check_variants(to_play(matches, read_results(folder)))
    make_folder(folder)
    provenance = provenance_of(grid)
    open_folder(folder, grid, provenance)
    with Shard(folder, index, count) as file:
        begun = _BegunShard(matches, read_results(folder))
        recordings = folder / "recordings" if record else None
        if recordings is not None:
            make_folder(recordings)
        begun.tell(again, other_code, unrecorded if record else no_op)
        progress(begun.done, len(matches))
        if begun.todo:
            add_metrics(folder, provenance)
            workers_here = pool(worker_count(workers, len(begun.todo)), grid.agent_limit_s, recordings)
            with closing(dispatch(workers_here, begun.todo)) as results:
                for done, _ in enumerate(_stored(results, folder, file), begun.done + 1):
                    progress(done, len(matches))
    return _finish(folder, grid, plan)


def _check(grid: Grid, index: int, count: int) -> None:
    """Raises MatchError when an agent is missing, or where there is no such shard."""
    missing = missing_agents(grid)
    if missing:
        raise MatchError(f"grid {grid.name!r} needs agents that are not here: {'; '.join(missing)}")
    if not 0 <= index < count:
        raise MatchError(f"shard {index}/{count}: the first number counts from 0 to {count - 1}")


class _BegunShard:
    """The matches of a shard, and those results of the folder that were there when it began, by the match's id."""

    def __init__(self, matches: Sequence[Match], finished: Mapping[str, MatchResult]) -> None:
        self._matches, self._finished = matches, finished
        self.todo = to_play(matches, finished)

    @property
    def done(self) -> int:
        """How many matches need not be played."""
        return len(self._matches) - len(self.todo)

    @property
    def failed(self) -> int:
        """How many matches are played again."""
        return sum(match.id in self._finished for match in self.todo)

    @property
    def of_other_code(self) -> int:
        """How many of the results are of other code of this project."""
        return of_other_code(self._finished[match.id] for match in self._matches if match.id in self._finished)

    @property
    def unrecorded(self) -> int:
        """How many of these matches are not played again and have no recording."""
        todo = {match.id for match in self.todo}
        return sum(match.id not in todo and not self._finished[match.id].recording for match in self._matches)

    def tell(self, again: OnAgain, other_code: OnOtherCode, unrecorded: OnUnrecorded) -> None:
        """Say what the earlier results mean for this run; nothing where there are none."""
        if failed := self.failed:
            again(failed)
        if self.todo and (other := self.of_other_code):
            other_code(other)
        if lacking := self.unrecorded:
            unrecorded(lacking)


def _finish(folder: Path, grid: Grid, plan: list[PlannedMatch]) -> GridRun:
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


def _stored(results: Iterator[MatchResult], folder: Path, file: Shard) -> Iterator[MatchResult]:
    """Each result once it is on disk."""
    for result in _kept(results, folder):
        file.append([result])
        _replace_earlier(folder, result)
        yield result


def _kept(results: Iterator[MatchResult], folder: Path) -> Iterator[MatchResult]:
    """Results as they are kept: paths of recordings relative to the results folder, so that it can be moved."""
    for result in results:
        path = Path(result.recording)
        if result.recording and path.is_relative_to(folder.resolve()):
            result = replace(result, recording=str(path.relative_to(folder.resolve())))
        yield with_code(result)


def _replace_earlier(folder: Path, result: MatchResult) -> None:
    """Remove recordings of a match that had no result, or failed, now that it is played through with one of its own.

    A match that fails again keeps them: which of its results is read, another shard may say.
    """
    for path in superseded(folder / result.recording) if result.recording and result.ending != "failed" else ():
        with suppress(OSError):  # a file that stays is no reason to stop
            path.unlink(missing_ok=True)
