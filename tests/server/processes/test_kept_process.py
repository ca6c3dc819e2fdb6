"""A process that ends is replaced, whatever ended it, until nobody wants it any more."""

import asyncio

import pytest

from movingout.server.processes import kept_process
from movingout.server.processes.kept_process import KeptProcess


class _Lives(KeptProcess):
    """Cannot be started at first, twice, then ends by itself, then lives until its channel is closed."""

    def __init__(self) -> None:
        super().__init__("the test")
        self.pid = 7
        self.count = 0
        self.last = asyncio.Event()
        self._closed = asyncio.Event()
        self._channel = self  # type: ignore[assignment]  # of which only `close` is used

    def close(self) -> None:
        self._closed.set()

    async def _one_life(self) -> None:
        self.count += 1
        if self.count == 1:
            raise OSError("no memory")
        if self.count == 2:
            raise ValueError("no number of a process")
        if self.count == 4:
            self.last.set()
            await self._closed.wait()


def test_it_is_replaced_until_it_is_stopped(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    monkeypatch.setattr(kept_process, "QUICK_DEATH_S", 0.0)
    lives = asyncio.run(_live_and_stop())
    assert (lives.count, lives.restarts) == (4, 3)
    said = [record.message for record in caplog.records]
    again = "the process 7 of the test has ended; starting another"
    assert said == [
        "the test cannot be run: no memory",
        again,
        "the test cannot be run: no number of a process",
        again,
        again,
    ]


async def _live_and_stop() -> _Lives:
    lives = _Lives()
    lives.begin()
    await lives.last.wait()
    await lives.stop()
    return lives
