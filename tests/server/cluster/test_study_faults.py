"""A study on several nodes whose database is away, whose disk is full, or whose clock jumps: it loses nothing."""

import json
import os
import shutil
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from movingout.server.study_bots.cohort import Cohort
from movingout.server.study_bots.simulation_plan import SimulationPlan
from tests.database import PostgresServer
from tests.server.cluster.partition import cable_to
from tests.server.cluster.processes import status, wait_until
from tests.server.cluster.study_nodes import StudyCluster, study_cluster, through

PLAN = SimulationPlan(4, speed=10.0, at_once=2)
AWAY_S = 30.0
HOUR_S = 3600
LEFT = 30_000_000  # bytes

pytestmark = pytest.mark.slow


def refusal(cluster: StudyCluster, path: str) -> dict[str, Any]:
    """The error that the proxy passes on."""
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{cluster.live.port}{path}", timeout=20.0) as answer:
            return {"code": "", "status": answer.status}
    except urllib.error.HTTPError as error:
        with error:
            return {**json.loads(error.read())["error"], "status": error.code}


def test_a_database_that_is_away_for_half_a_minute_stops_the_study_and_loses_nothing(
    tmp_path: Path, database_server: PostgresServer
) -> None:
    with cable_to(database_server.new_database()) as (cable, database), study_cluster(tmp_path, database) as cluster:

        def trouble(cohort: Cohort) -> None:
            wait_until(through(3, cohort), "rounds begin")
            cable.cut()
            begun = time.monotonic()
            away = wait_until(lambda: (told := refusal(cluster, "/api/study"))["code"] and told, "it is noticed")
            assert (away["status"], away["code"]) == (503, "moving") and "goes on in a few seconds" in away["message"]
            assert status(cluster.live.port, "/study") == 200, "pages are there, and ask again by themselves"
            wait_until(lambda: time.monotonic() - begun > AWAY_S, "half a minute passes")
            cable.mend()
            wait_until(cluster.is_served, "the study goes on")

        cluster.check(cluster.take_part(PLAN, trouble))
        for node in cluster.nodes:
            assert any("does not answer" in line for line in node.told()), "the operator reads why"
            assert not any("Traceback" in line for line in node.told())


@contextmanager
def small_disk(folder: Path, megabytes: int) -> Iterator[Path]:
    """A file system of its own, for one `with` block; skips where this user may mount none."""
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={megabytes}m", "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True).returncode != 0:
        pytest.skip("this user may not mount a small file system")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


def fill(disk: Path) -> Path:
    """A file that leaves less than rounds need to begin, and enough for those that have begun."""
    ballast = disk / "ballast"
    with ballast.open("wb") as file:
        os.posix_fallocate(file.fileno(), 0, shutil.disk_usage(disk).free - LEFT)
    return ballast


def test_a_full_disk_lets_no_round_begin_and_afterwards_all_are_played(
    tmp_path: Path, database_server: PostgresServer
) -> None:
    with (
        small_disk(tmp_path / "disk", 200) as disk,
        study_cluster(tmp_path, database_server.new_database(), disk / "data") as cluster,
    ):

        def trouble(cohort: Cohort) -> None:
            wait_until(through(3, cohort), "rounds begin")
            ballast = fill(disk)
            wait_until(
                lambda: any("disk is almost full" in line for one in cluster.nodes for line in one.told()), "told"
            )
            time.sleep(5.0)
            assert cluster.is_served(), "answers are in the database, which has another disk"
            ballast.unlink()

        cohort = cluster.take_part(PLAN, trouble)
        stored = cluster.check(cohort)
        assert {row["outcome"] for row in stored.participants.values()} == {"done"}
        assert not any("Traceback" in line for node in cluster.nodes for line in node.told())


@pytest.fixture
def wall_clock(tmp_path: Path) -> tuple[Path, Path]:
    """A library that moves the wall clock of a process, and the file that says by how much."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler to build the clock of this test with")
    library, offset = tmp_path / "wall_clock.so", tmp_path / "offset"
    source = Path(__file__).with_name("wall_clock.c")
    subprocess.run([compiler, "-shared", "-fPIC", "-o", str(library), str(source), "-ldl"], check=True)
    jump(offset, 0)
    return library, offset


def jump(offset: Path, seconds: int) -> None:
    """Move the clocks of all processes that have this file mapped."""
    with offset.open("r+b" if offset.exists() else "wb") as file:
        file.write(seconds.to_bytes(8, "little", signed=True))


def test_clocks_that_jump_end_no_round_and_no_session(
    tmp_path: Path, database_server: PostgresServer, wall_clock: tuple[Path, Path]
) -> None:
    library, offset = wall_clock
    clock = {"LD_PRELOAD": str(library), "WALL_CLOCK_OFFSET": str(offset)}
    begun_ms = time.time() * 1e3
    with study_cluster(tmp_path, database_server.new_database(), environment=clock) as cluster:

        def trouble(cohort: Cohort) -> None:
            wait_until(through(3, cohort), "rounds begin")
            for seconds in (HOUR_S, -2 * HOUR_S):
                jump(offset, seconds)
                time.sleep(3.0)
                assert cluster.is_served()
            killed = cluster.leader()
            killed.kill()  # rooms and sessions are read again under the new time
            wait_until(cluster.is_served, "the other node goes on")
            killed.start()

        cohort = cluster.take_part(PLAN, trouble)
        stored = cluster.check(cohort)
        assert {row["outcome"] for row in stored.participants.values()} == {"done"}
        stamps = [datetime.fromisoformat(at).timestamp() for node in cluster.nodes for at in node.told("at")]
        assert min(stamps) < begun_ms / 1e3 - HOUR_S / 2, "the clock of this test works"
        lasted = [row["finished_ms"] - row["arrived_ms"] for row in stored.participants.values()]
        assert all(0 <= each <= time.time() * 1e3 - begun_ms for each in lasted), lasted
