"""The watch over an agent worker, with a clock that is set by hand."""

import asyncio
from types import SimpleNamespace
from typing import cast

from movingout.agents.worker.heartbeat import Activity, WorkerHeartbeat
from movingout.server.agent_workers.process import HANG_S, WATCH_EVERY_S, _watch

NAPS = int(HANG_S["idle"] / WATCH_EVERY_S)


def lost(naps: list[float]) -> bool:
    """Whether an idle worker is given up that says nothing more, where each sleep of the watch lasts as given [s]."""
    clock, left = [100.0], list(naps)

    async def sleep(_seconds: float) -> None:
        if not left:
            raise asyncio.CancelledError
        clock[0] += left.pop(0)

    said = iter([Activity(99.0, "loading", None)])  # its start
    heartbeat = SimpleNamespace(read=lambda: next(said, Activity(100.0, "idle", None)))
    try:
        asyncio.run(_watch(cast(WorkerHeartbeat, heartbeat), lambda: clock[0], sleep))
    except asyncio.CancelledError:
        return False
    return True


def test_a_worker_that_says_nothing_for_too_long_is_given_up() -> None:
    assert not lost([WATCH_EVERY_S] * NAPS)
    assert lost([WATCH_EVERY_S] * (NAPS + 1))


def test_after_a_standstill_of_the_whole_machine_it_has_time_to_speak() -> None:
    assert not lost([WATCH_EVERY_S, 60.0, *[WATCH_EVERY_S] * NAPS])
    assert lost([WATCH_EVERY_S, 60.0, *[WATCH_EVERY_S] * (NAPS + 1)])
