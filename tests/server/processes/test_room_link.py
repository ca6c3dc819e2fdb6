"""The front's watch over a process with rooms, with a clock that is set by hand."""

import asyncio
import signal
from typing import Any, cast

import pytest

from movingout.server.processes.room_link import SILENT_S, WATCH_S, RoomLink


def killed(monkeypatch: pytest.MonkeyPatch, naps: list[float]) -> list[float]:
    """When a ready process that says nothing is killed, where each sleep of the watch lasts as long as given [s]."""
    clock, kills, left = [100.0], [], list(naps)

    async def sleep(_seconds: float) -> None:
        if not left:
            raise asyncio.CancelledError
        clock[0] += left.pop(0)

    def kill(number: signal.Signals) -> None:
        assert number == signal.SIGKILL
        kills.append(clock[0] - 100.0)

    nothing = cast(Any, None)
    link = RoomLink(0, nothing, nothing, nothing)
    link._heard = clock[0]
    link._ready.set()
    monkeypatch.setattr(link, "_kill", kill)
    with pytest.raises(asyncio.CancelledError):
        asyncio.run(link._watch(lambda: clock[0], sleep))
    return kills


def test_a_process_that_is_silent_for_too_long_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    naps = int(SILENT_S / WATCH_S)
    assert killed(monkeypatch, [WATCH_S] * naps) == []
    assert killed(monkeypatch, [WATCH_S] * (naps + 1)) == [SILENT_S + WATCH_S]


def test_after_a_standstill_of_the_whole_machine_nobody_is_killed_who_had_no_time_to_speak(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    naps = int(SILENT_S / WATCH_S)
    assert killed(monkeypatch, [WATCH_S, 60.0, *[WATCH_S] * naps]) == []
    assert len(killed(monkeypatch, [WATCH_S, 60.0, *[WATCH_S] * (naps + 1)])) == 1
