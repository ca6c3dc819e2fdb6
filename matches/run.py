"""Plays one pair, or a list of matches: the functions to call from a notebook; a whole grid is in `.grid_run`."""

import warnings
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from movingout.maps.selection import selected_maps
from movingout.matches.callbacks import OnProgress, OnResult, WorkerPoolFactory, no_op, warn_caller
from movingout.matches.execution.agent_objects import AgentLike, AgentObjects
from movingout.matches.execution.dispatch import dispatch
from movingout.matches.execution.local_workers import LocalWorkerPool
from movingout.matches.execution.lockstep import AGENT_LIMIT_S, Lockstep
from movingout.matches.execution.recorder import recorded_before
from movingout.matches.experiment.plan import agent_for_seed, load_for_workers
from movingout.matches.match import Challenge, Match, MatchResult, check_numbers
from movingout.matches.preparation import cautions, check_own_maps, make_folder, worker_count
from movingout.world.constants import LIMIT_TICKS


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
    for sentence in cautions(matches):
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
    size = worker_count(workers, len(todo))
    with closing(dispatch(pool(size, agent_limit_s, record), todo)) as results:
        for result in results:
            found[result.match] = result
            on_result(result)
            progress(len(found), len(todo))
    return [found[match] for match in matches]
