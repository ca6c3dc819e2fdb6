"""A process that dies: only whose work ended it hears of that, and one other takes its place."""

import asyncio
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any

import pytest

from movingout.recordings import RecordingError
from movingout.server.persistence import work_process
from movingout.server.persistence.work_process import WorkProcess


class MortalPool(ThreadPoolExecutor):
    """A process that `die` ends, with all that waits for it."""

    dead = False

    def submit(self, work: Any, /, *arguments: Any, **options: Any) -> "Future[Any]":
        return super().submit(self._attempt, work, *arguments)

    def end(self, within_s: float) -> None:
        self.shutdown(cancel_futures=True)

    def _attempt(self, work: Any, *arguments: Any) -> Any:
        self.dead = self.dead or work is die
        if self.dead:
            raise BrokenProcessPool
        return work(*arguments)


def die() -> None: ...


@pytest.fixture
def pools(monkeypatch: pytest.MonkeyPatch) -> list[MortalPool]:
    """All processes that were started."""
    made: list[MortalPool] = []

    def process_pool(workers: int, nice: int) -> MortalPool:
        made.append(MortalPool(workers))
        return made[-1]

    monkeypatch.setattr(work_process, "process_pool", process_pool)
    return made


def test_a_death_costs_the_others_that_wait_nothing(pools: list[MortalPool]) -> None:
    async def work() -> list[Any]:
        process = WorkProcess("tests")
        calls = [process.run(abs, -1), process.run(die), *(process.run(abs, -number) for number in range(2, 7))]
        found = await asyncio.gather(*calls, return_exceptions=True)
        await process.close()
        return found

    first, died, *others = asyncio.run(work())
    assert isinstance(died, RecordingError) and "died twice" in str(died)
    assert [first, *others] == [1, 2, 3, 4, 5, 6]
    assert len(pools) == 3, "each death is followed by one new process"
    assert all(pool._shutdown for pool in pools)


def test_what_waits_when_the_process_is_closed_is_refused(pools: list[MortalPool]) -> None:
    async def work() -> list[Any]:
        process = WorkProcess("tests")
        calls = asyncio.gather(*(process.run(abs, -number) for number in range(3)), return_exceptions=True)
        await asyncio.sleep(0)
        await process.close()
        return await calls

    first, *others = asyncio.run(work())
    assert first == 0
    assert [str(other) for other in others] == ["the process for tests is being stopped"] * 2
