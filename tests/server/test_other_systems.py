"""What only Linux has is not needed to play, serve, record and evaluate: macOS has fewer calls, and other limits."""

import argparse
import errno
import os
import resource
import socket
from pathlib import Path

import pytest

from movingout.agents.worker.process import limit_memory
from movingout.matches import play
from movingout.matches.results.results_folder import Shard, read_results
from movingout.server import settings
from movingout.server.agent_workers.capacity import per_worker
from movingout.server.open_files import raise_open_files
from movingout.server.processes.message_sockets import has_message_sockets
from movingout.server.settings import Limits
from tests.recordings.support import begin
from tests.recordings.support import play as play_ticks


@pytest.fixture(autouse=True)
def without_linux(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("sched_getaffinity", "fdatasync", "memfd_create"):
        monkeypatch.delattr(os, name, raising=False)


def test_agents_share_the_cores_of_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    assert per_worker(2) == per_worker(2, cores=2)


def test_a_match_is_kept_in_its_grid(tmp_path: Path) -> None:
    results = play("idle", "idle", ticks=1, workers=1)
    with Shard(tmp_path) as shard:
        shard.append(results)
    assert list(read_results(tmp_path).values()) == results


def test_a_round_that_is_recorded_is_synced(tmp_path: Path) -> None:
    writer, played = begin(tmp_path)
    play_ticks(writer, played, 1)
    writer.sync()
    writer.abandon()


def test_files_may_be_opened_as_far_as_the_system_allows(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[int] = []

    def raised(_: int, limit: tuple[int, int]) -> None:
        if limit[0] > 24_576:  # kern.maxfilesperproc
            raise ValueError("current limit exceeds maximum limit")
        told.append(limit[0])

    monkeypatch.setattr(resource, "setrlimit", raised)
    monkeypatch.setattr(resource, "getrlimit", lambda _: (256, resource.RLIM_INFINITY))
    assert raise_open_files(Limits(sockets=2000, rooms=250)) == ""
    assert told == [10_240]


def test_an_agent_plays_where_its_memory_cannot_be_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(_: int, limit: tuple[int, int]) -> None:
        raise ValueError("current limit exceeds maximum limit")

    monkeypatch.setattr(resource, "setrlimit", refused)
    limit_memory()


def test_more_processes_than_the_system_has_sockets_for_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> tuple[socket.socket, socket.socket]:
        raise OSError(errno.EPROTONOSUPPORT, "Protocol not supported")

    assert has_message_sockets()
    monkeypatch.setattr(socket, "socketpair", refused)
    assert not has_message_sockets()
    monkeypatch.setattr(settings, "SEVERAL_PROCESSES", False)
    assert settings.process_count("1") == 1
    with pytest.raises(argparse.ArgumentTypeError, match="only 1 is possible, not 4: this system lacks the sockets"):
        settings.process_count("4")
