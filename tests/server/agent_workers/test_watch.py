"""The watch over an agent worker, with a clock that is set by hand."""

import asyncio
import time
from types import SimpleNamespace
from typing import cast

import pytest

from movingout.agents.worker.heartbeat import Activity, WorkerHeartbeat
from movingout.server.agent_workers.process import HANG_S, WATCH_EVERY_S, _watch

NAPS = int(HANG_S["idle"] / WATCH_EVERY_S)


def lost(monkeypatch: pytest.MonkeyPatch, naps: list[float]) -> bool:
    """Whether an idle worker is given up that says nothing more, where each sleep of the watch lasts as given [s]."""
    clock, left = [100.0], list(naps)

    async def sleep(_seconds: float) -> None:
        if not left:
            raise asyncio.CancelledError
        clock[0] += left.pop(0)

    said = iter([Activity(99.0, "loading", None)])  # its start
    heartbeat = SimpleNamespace(read=lambda: next(said, Activity(100.0, "idle", None)))
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(asyncio, "sleep", sleep)
    try:
        asyncio.run(_watch(cast(WorkerHeartbeat, heartbeat)))
    except asyncio.CancelledError:
        return False
    return True


def test_a_worker_that_says_nothing_for_too_long_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not lost(monkeypatch, [WATCH_EVERY_S] * NAPS)
    assert lost(monkeypatch, [WATCH_EVERY_S] * (NAPS + 1))


def test_after_a_standstill_of_the_whole_machine_it_has_time_to_speak(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not lost(monkeypatch, [WATCH_EVERY_S, 60.0, *[WATCH_EVERY_S] * NAPS])
    assert lost(monkeypatch, [WATCH_EVERY_S, 60.0, *[WATCH_EVERY_S] * (NAPS + 1)])
