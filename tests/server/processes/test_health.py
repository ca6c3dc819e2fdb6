"""What a server with several processes says of itself when one of them does not come back, and what it measures."""

import json
import os
import re
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NoReturn, cast

import pytest

from movingout.server.agent_workers import process_restarts
from movingout.server.processes import agent_link, agent_service
from movingout.server.processes.front import Front
from movingout.server.processes.template import TemplateProcess
from tests.server.live import ADMIN, Live
from tests.server.monitoring.test_metrics import scraped
from tests.server.processes.cluster import cluster, links

WITHIN_S = 30.0


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    with cluster(tmp_path_factory.mktemp("health")) as live:
        yield live


def until(condition: Callable[[], Any]) -> Any:
    deadline = time.monotonic() + WITHIN_S
    while not (found := condition()):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return found


def faults(live: Live) -> list[str]:
    status, answer = live.call("/healthz")
    assert (status == 503) == bool(answer["faults"])
    return list(answer["faults"])


def away(live: Live, what: str) -> bool:
    return any(fault.startswith(f"{what}: away for ") for fault in faults(live))


def no_files(*_: object) -> NoReturn:
    raise OSError(24, "Too many open files")


def no_number(*_: object) -> NoReturn:
    raise ValueError("invalid literal")


@pytest.mark.slow
def test_rooms_whose_process_cannot_be_started_are_a_fault_until_it_can(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    until(lambda: not faults(live))
    monkeypatch.setattr(process_restarts, "AWAY_S", 2.5)  # the news come once a second
    with monkeypatch.context() as broken:
        broken.setattr(TemplateProcess, "copy", no_number)
        os.kill(links(live)[0].pid, signal.SIGKILL)
        until(lambda: away(live, "the rooms 0"))
        assert scraped(live)["movingout_faults"] >= 1
    until(lambda: not faults(live))


@pytest.mark.slow
def test_an_agent_service_that_cannot_be_started_is_a_fault_until_it_can(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    until(lambda: not faults(live))
    monkeypatch.setattr(process_restarts, "AWAY_S", 2.5)
    with monkeypatch.context() as broken:
        broken.setattr(agent_link, "_spawn", no_files)
        os.kill(cast(Front, live.host).agents.pid, signal.SIGKILL)
        until(lambda: away(live, "the agent service"))
    until(lambda: not faults(live))


@pytest.mark.slow
def test_what_does_not_work_in_the_agent_service_is_told_by_the_front(live: Live) -> None:
    front = cast(Front, live.host)

    def told() -> list[str]:
        agent_service.heard(front.agents, ("an agent worker: away for 31 s",))
        return front.faults()

    assert "an agent worker: away for 31 s" in live.run(told)
    until(lambda: not faults(live))  # the service's own news follow


def test_while_a_process_is_replaced_the_counts_of_the_others_stay_theirs(live: Live) -> None:
    """Or Prometheus counts what is there already once more: a false alarm about hundreds of missed ticks."""
    until(lambda: {"movingout_ticks_total,process=0", "movingout_ticks_total,process=1"} <= set(scraped(live)))
    live.host.admission.refusals["full"] += 7
    first = links(live)[0]
    live.run(first.leaving)
    assert scraped(live)["movingout_refusals_total,process=front,reason=full"] == 7
    without = [name for name in scraped(live) if re.search("process=[01]", name)]
    assert "movingout_ticks_total,process=1" in without and "process_open_fds,process=1" in without
    assert not [name for name in without if "process=0" in name]
    live.run(lambda: first.became_ready(dict.fromkeys(first.rooms, "")))
    until(lambda: "movingout_ticks_total,process=0" in scraped(live))


def test_the_metrics_tell_of_agents_and_of_every_process(live: Live) -> None:
    live.open_room("here", "scripted")

    def measured() -> dict[str, float]:
        found = scraped(live)
        return found if found.get("movingout_agent_seats,worker=0") == 1 else {}

    found = until(measured)
    assert found["movingout_agent_load,worker=0"] >= 0 and "movingout_agent_restarts_total,worker=0" in found
    assert found["movingout_agent_overruns_total,worker=0"] == 0
    for name in ("process_open_fds", "process_max_fds", "process_resident_memory_bytes", "process_cpu_seconds_total"):
        assert {f"{name},process={each}" for each in ("0", "1", "front", "agents")} <= set(found), name
    assert live.call("/api/admin/state", token=ADMIN)[1]["agents"][0]["seats"] == 1


@pytest.mark.slow
def test_the_log_of_the_agent_service_is_that_of_the_server(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with cluster(tmp_path, log_format="json") as live:
        worker = until(lambda: live.call("/api/admin/state", token=ADMIN)[1]["agents"])[0]
        os.kill(int(until(lambda: worker["pid"])), signal.SIGKILL)
        said = until(lambda: [line for line in capfd.readouterr().err.splitlines() if "lost while idle" in line])
    assert json.loads(said[0])["message"] == f"agent worker {worker['pid']} lost while idle; starting another"
