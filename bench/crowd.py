"""A short study over two nodes, PostgreSQL and HAProxy, while the node that runs it is killed again and again.

Options: `--participants N` (1000), `--at-once N` (40), `--speed X` (5), `--kill-every S` (60). Needs Debian's
postgresql and haproxy. Prints what was stored, and fails where an answer, a round or a code is not there exactly once,
or a recording does not verify.
"""

import argparse
import tempfile
import time
from collections import Counter
from pathlib import Path

import pytest

from movingout.server.study_bots.cohort import Cohort
from movingout.server.study_bots.simulation_plan import SimulationPlan
from tests.database import postgres_server
from tests.server.cluster.processes import wait_until
from tests.server.cluster.study_nodes import StudyCluster, study_cluster


def main(options: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench crowd", description=__doc__)
    parser.add_argument("--participants", type=int, default=1000)
    parser.add_argument("--at-once", type=int, default=40)
    parser.add_argument("--speed", type=float, default=5.0)
    parser.add_argument("--kill-every", type=float, default=60.0, metavar="S")
    args = parser.parse_args(options)
    plan = SimulationPlan(args.participants, speed=args.speed, at_once=args.at_once)
    try:
        _serve(plan, args.speed, args.kill_every)
    except pytest.skip.Exception as missing:  # PostgreSQL or HAProxy
        print(f"crowd: not measured: {missing}")


def _serve(plan: SimulationPlan, speed: float, kill_every_s: float) -> None:
    with (
        tempfile.TemporaryDirectory(prefix="movingout-crowd-") as folder,
        postgres_server() as server,
        study_cluster(Path(folder), server.new_database(), speed=speed, lease_s=5.0) as cluster,
    ):
        _measure(cluster, plan, kill_every_s)


def _measure(cluster: StudyCluster, plan: SimulationPlan, kill_every_s: float) -> None:
    back_s: list[float] = []  # from each kill until the study is served again

    def kill(_: Cohort) -> None:
        while not cluster.over.wait(kill_every_s):
            killed, begun = cluster.leader(), time.monotonic()
            killed.kill()
            wait_until(cluster.is_served, "the other node goes on")
            back_s.append(time.monotonic() - begun)
            killed.start()
            wait_until(killed.is_ready, "it is back")

    begun = time.monotonic()
    cohort = cluster.take_part(plan, kill)
    took = time.monotonic() - begun
    stored = cluster.check(cohort)
    rounds = Counter(row["outcome"] for row in stored.rounds)
    codes = len({row["code"] for row in stored.participants.values()})
    print(f"{plan.participants} participants in {took:.0f} s: {len(stored.answers)} answers, {codes} codes, all once")
    print(f"rounds by outcome: {dict(rounds)}")
    longest = f", the study was served again after {max(back_s):.1f} s at most" if back_s else ""
    print(f"{len(back_s)} kills of the node that runs the study{longest}")
