"""A study on two real nodes behind a real HAProxy: participants land on either, nodes die, and nothing is lost."""

import signal
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.server.study_bots.cohort import Cohort
from movingout.server.study_bots.simulation_plan import SimulationPlan
from tests.database import PostgresServer
from tests.server.cluster.processes import wait_until
from tests.server.cluster.study_nodes import STUDY, study_cluster, through

PARTICIPANTS = 6


@pytest.mark.slow
def test_nodes_are_killed_and_stopped_and_everything_is_there_once(
    tmp_path: Path, database_server: PostgresServer
) -> None:
    with study_cluster(tmp_path, database_server.new_database()) as cluster:

        def trouble(cohort: Cohort) -> None:
            wait_until(through(3, cohort), "rounds begin")
            killed = cluster.leader()
            killed.kill()
            wait_until(cluster.is_served, "the other node goes on")
            killed.start()
            wait_until(killed.is_ready, "it is back")
            stopped = cluster.leader()
            stopped.send(signal.SIGSTOP)
            wait_until(lambda: killed.runs_the_study, "a node that hangs does not run the study")
            stopped.send(signal.SIGCONT)
            wait_until(lambda: not stopped.runs_the_study, "it has noticed")

        cluster.check(cluster.take_part(SimulationPlan(PARTICIPANTS, speed=10.0, chaos=True), trouble))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--node", "a"], "needs both"),
        (["--lease", "10"], "needs both"),
        (["--node", "a", "--cluster", "nonsense"], "share PostgreSQL databases; --cluster nonsense is none"),
        (["--node", "a", "--cluster", "postgresql://h:port/d"], "is no address of a database"),
        (
            ["--node", "a", "--cluster", "postgresql://h/d", "--identities", "who.sqlite"],
            "--identities who.sqlite is none",
        ),
        (["--node", "a", "--cluster", "postgresql://h/d", "--processes", "31"], "one process"),
    ],
)
def test_what_a_node_of_a_study_cannot_start_with_is_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], sentence: str
) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(STUDY, encoding="utf-8")
    assert main(["study", "serve", str(file), "--rehearse", "5", "--data", str(tmp_path / "data"), *options]) == 2
    assert sentence in capsys.readouterr().err
