"""How well matches scale: the same ones with one worker and with two, as processes and on a Ray cluster of two nodes.

Run nothing else. The runs take turns. Efficiency is the time of one worker divided by twice that of two; beside
it stand the time until the first result and what a match costs more when both cores are busy.
"""

import argparse
import importlib
import statistics
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from bench import print_table
from movingout.maps import map_names
from movingout.matches.callbacks import WorkerPoolFactory
from movingout.matches.execution.local_workers import LocalWorkerPool
from movingout.matches.execution.ray_workers import ray_worker_pool
from movingout.matches.match import Match, MatchResult
from movingout.matches.run import play_matches


class TimedRun(NamedTuple):
    """One run; times in seconds."""

    wall: float
    first: float  # until the first result
    matches_cpu: float  # processor time of all matches


def main(words: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench scaling", description=__doc__)
    parser.add_argument("--agent", default="scripted", metavar="ID", help="plays both seats (%(default)s)")
    parser.add_argument("--per-map", type=int, default=8, metavar="N", help="matches on each of 12 maps (%(default)s)")
    parser.add_argument("--pairs", type=int, default=2, metavar="N", help="runs of each kind (%(default)s)")
    args = parser.parse_args(words)
    matches = [Match(name, args.agent, args.agent, seed) for seed in range(args.per_map) for name in map_names()]
    pools: dict[str, WorkerPoolFactory] = {"processes": LocalWorkerPool}
    with _two_nodes() as address:
        pools["Ray, two nodes"] = ray_worker_pool(address)
        runs: dict[tuple[str, int], list[TimedRun]] = {(name, workers): [] for name in pools for workers in (1, 2)}
        for _ in range(args.pairs):
            for name, workers in runs:
                runs[name, workers].append(timed_run(matches, workers, pools[name]))
    print_table(
        f"{len(matches)} matches of {args.agent} with itself, medians of {args.pairs} runs",
        ["workers are", "one [s]", "two [s]", "efficiency", "first result [s]", "a match costs more"],
        [_row(name, runs[name, 1], runs[name, 2]) for name in pools],
    )


def timed_run(matches: Sequence[Match], workers: int, pool: WorkerPoolFactory) -> TimedRun:
    begun, arrived = time.monotonic(), list[float]()

    def note(_: MatchResult) -> None:
        arrived.append(time.monotonic() - begun)

    results = play_matches(matches, workers=workers, pool=pool, on_result=note)
    return TimedRun(time.monotonic() - begun, arrived[0], sum(result.cpu_s for result in results))


def _row(name: str, one: Sequence[TimedRun], two: Sequence[TimedRun]) -> list[str]:
    alone, together = (statistics.median(run.wall for run in runs) for runs in (one, two))
    cost = statistics.median(run.matches_cpu for run in two) / statistics.median(run.matches_cpu for run in one)
    first = statistics.median(run.first for run in two)
    return [name, f"{alone:.1f}", f"{together:.1f}", f"{alone / together / 2:.2f}", f"{first:.1f}", f"{cost - 1:+.0%}"]


@contextmanager
def _two_nodes() -> Iterator[str]:
    """The address of a cluster of two nodes of one processor each, on this machine."""
    warnings.simplefilter("ignore")  # Ray's own
    importlib.import_module("ray")
    from ray.cluster_utils import Cluster

    cluster: Any = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    cluster.add_node(num_cpus=1)
    try:
        yield cluster.address
    finally:
        importlib.import_module("ray").shutdown()
        cluster.shutdown()
