"""Which servers accept simulated participants, and the errors of the others."""

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest

from movingout.server.study_bots import cohort as cohorts
from movingout.server.study_bots.cohort import Cohort
from movingout.server.study_bots.simulation_plan import SimulationPlan
from movingout.server.study_bots.study_client import SimulationError
from tests.server.study.support import served


def _visit(base: str) -> None:
    asyncio.run(Cohort(base, SimulationPlan(1, scripted=False)).take_part())


def test_a_study_of_real_people_is_never_visited(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        with pytest.raises(SimulationError, match="real participants"):
            _visit(f"http://{study.live.address}")
        assert study.state()["participants"] == []


def test_where_nothing_is_served_it_is_said_so() -> None:
    with pytest.raises(SimulationError, match="no study is being served at http"):
        _visit("http://127.0.0.1:9")


@contextmanager
def answering(*statuses: int) -> Iterator[str]:
    """The address of a server that answers with these, one after the other, and at last with a study of real people."""
    left = list(statuses)

    class Answer(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(left.pop(0) if left else 200)
            self.end_headers()
            self.wfile.write(b"{}")

        def log_message(self, *_: object) -> None:
            """Nothing."""

    with HTTPServer(("127.0.0.1", 0), Answer) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


def test_who_comes_while_the_study_moves_to_another_node_waits_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cohorts, "RETRY_S", 0.01)
    with answering(503, 502, 503) as base, pytest.raises(SimulationError, match="real participants"):
        _visit(base)


def test_a_study_that_does_not_come_back_is_not_waited_for_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cohorts, "RETRY_S", 0.01)
    monkeypatch.setattr(cohorts, "GIVE_UP_S", 0.05)
    with answering(*[503] * 20) as base, pytest.raises(SimulationError, match=r"no study is being served .*503"):
        _visit(base)
