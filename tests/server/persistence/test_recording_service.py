"""The processes that finish and read recordings: apart, started again when they die, and asked once for the same."""

import asyncio
import json
import os
import signal
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from movingout.recordings import RecordingError, finalise
from movingout.server.persistence import recording_service, work_process
from movingout.server.persistence.recording_service import RecordingService
from tests.recordings.support import record


def run(folder: Path, work: Callable[[RecordingService], Awaitable[Any]]) -> Any:
    """What `work` returns, with a service that is closed in the end."""

    async def serve() -> Any:
        service = RecordingService(folder)
        try:
            return await work(service)
        finally:
            await service.close()

    return asyncio.run(serve())


def journal_in(folder: Path, ticks: int = 3) -> Path:
    return record(folder, ticks=ticks, map_name="LeftRight")[0]


def _sleep(seconds: float) -> float:
    time.sleep(seconds)
    return seconds


def _die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.slow
def test_who_asks_for_replays_delays_nobodys_recording(tmp_path: Path) -> None:
    journal = journal_in(tmp_path)

    async def work(service: RecordingService) -> bool:
        slow = [asyncio.create_task(service._reading.run(_sleep, 1.5)) for _ in range(4)]
        service.finalise(journal)
        await service.settled()
        busy = not any(task.done() for task in slow[1:])
        await asyncio.gather(*slow)
        return busy

    assert run(tmp_path, work), "finished while replays were still waiting"
    assert not journal.exists()


def test_a_replay_that_many_ask_for_is_made_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    episode = finalise(journal_in(tmp_path)).stem
    made: list[str] = []

    async def work(service: RecordingService) -> int:
        read = service._reading.run

        async def counting(*arguments: Any, **options: Any) -> Any:
            made.append(episode)
            return await read(*arguments, **options)

        monkeypatch.setattr(service._reading, "run", counting)
        found = await asyncio.gather(*[service.replay(episode) for _ in range(12)])
        assert service.has_replay(episode)
        await service.replay(episode)
        return len({one.poses for one in found})

    assert (run(tmp_path, work), made) == (1, [episode])


def test_a_journal_that_could_not_be_finished_is_named_and_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal = journal_in(tmp_path)
    monkeypatch.setattr(recording_service, "RETRY_S", (0.05,))

    async def work(service: RecordingService) -> str:
        run_there, failures = (
            service._finishing.run,
            iter([RecordingError("No space left on device"), ValueError("odd")]),
        )

        async def failing(*arguments: Any, **options: Any) -> Any:
            for failure in failures:
                raise failure
            return await run_there(*arguments, **options)

        monkeypatch.setattr(service._finishing, "run", failing)
        service.finalise(journal)
        await service.settled()
        problem = service.unfinished[journal.name]
        while service.unfinished:
            await asyncio.sleep(0.05)
        return problem

    assert run(tmp_path, work) == "No space left on device"
    assert [path.suffix for path in tmp_path.iterdir()] == [".mcap"]


def test_it_is_known_for_how_long_finishing_stands_still(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It waited for ever behind a disk that hangs, and nothing told anybody."""
    now = [100.0]

    async def work() -> list[float]:
        service, goes_on, seen = RecordingService(tmp_path, clock=lambda: now[0]), asyncio.Semaphore(0), list[float]()

        async def hanging(*arguments: Any, **options: Any) -> None:
            await goes_on.acquire()
            raise RecordingError("an input/output error")

        def look(then_s: float) -> None:
            now[0] += then_s
            seen.append(service.stands_still_s)

        monkeypatch.setattr(service._finishing, "run", hanging)
        look(1.0)
        service.finalise(tmp_path / "one.mcap.journal")
        look(400.0)
        service.finalise(tmp_path / "two.mcap.journal")
        look(20.0)
        goes_on.release()
        while service.pending > 1:
            await asyncio.sleep(0)
        look(3.0)
        goes_on.release()
        await service.settled()
        look(5.0)
        await service.close()
        return seen

    assert asyncio.run(work()) == [0.0, 400.0, 420.0, 3.0, 0.0]


def test_a_journal_that_was_deleted_is_not_tried_again(tmp_path: Path) -> None:
    journal = journal_in(tmp_path)

    async def work(service: RecordingService) -> bool:
        journal.unlink()
        service.finalise(journal)
        await service.settled()
        return service.knows(journal) or bool(service.unfinished)

    assert run(tmp_path, work) is False


@pytest.mark.slow
def test_a_process_that_dies_twice_is_an_error_and_the_next_call_works(tmp_path: Path) -> None:
    async def work(service: RecordingService) -> float:
        with pytest.raises(RecordingError, match="died twice; is there enough memory"):
            await service._reading.run(_die)
        return float(await service._reading.run(_sleep, 0.01))

    assert run(tmp_path, work) == 0.01


@pytest.mark.slow
def test_a_long_queue_is_refused_but_for_recordings_to_finish(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work_process, "MOST_WAITING", 2)

    async def work(service: RecordingService) -> float:
        waiting = [asyncio.create_task(service._reading.run(_sleep, 0.3)) for _ in range(2)]
        await asyncio.sleep(0.05)
        with pytest.raises(RecordingError, match="try again in a minute"):
            await service._reading.run(_sleep, 0.0)
        urgent = await service._reading.run(_sleep, 0.02, urgent=True)
        await asyncio.gather(*waiting)
        return float(urgent)

    assert run(tmp_path, work) == 0.02


def _finalise_slowly(journal: Path) -> Path:
    time.sleep(1.0)
    return finalise(journal)


@pytest.mark.slow
def test_a_server_that_ends_does_not_wait_for_a_long_queue_and_the_next_one_finishes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    journals = [record(tmp_path, 3, episode_id=f"episode-{number}")[0] for number in range(6)]
    monkeypatch.setattr(recording_service, "finalise", _finalise_slowly)
    monkeypatch.setattr(recording_service, "CLOSE_S", 0.1)

    async def begin(service: RecordingService) -> None:
        for journal in journals:
            service.finalise(journal)

    run(tmp_path, begin)
    left = [journal for journal in journals if journal.exists()]
    assert left, "the last of a queue are not waited for"
    assert "stay journals; the next start finishes them" in caplog.text

    async def recover(service: RecordingService) -> None:
        for journal in left:
            service.recover(journal)
        await service.settled()

    run(tmp_path, recover)
    assert len(list(tmp_path.glob("*.mcap"))) == len(journals)
    assert not list(tmp_path.glob("*.journal"))


def test_a_recording_that_is_deleted_or_replaced_is_no_longer_served_from_memory(tmp_path: Path) -> None:
    """A participant who had asked for the deletion could still be watched until eight others were."""
    path = finalise(journal_in(tmp_path))
    other = finalise(record(tmp_path / "elsewhere", ticks=5, map_name="LeftRight")[0])

    async def work(service: RecordingService) -> None:
        first = (await service.replay("episode")).poses
        assert service.has_replay("episode")
        other.replace(path)
        assert not service.has_replay("episode")
        assert len((await service.replay("episode")).poses) > len(first)
        path.unlink()
        assert not service.has_replay("episode")
        with pytest.raises(RecordingError, match="there is no such recording"):
            await service.replay("episode")

    run(tmp_path, work)


def test_a_recording_under_another_name_is_found_by_its_id_and_a_link_is_not(tmp_path: Path) -> None:
    """It was listed, and Replay and Download answered that there is no such recording."""
    path = finalise(journal_in(tmp_path / "elsewhere"))
    (tmp_path / "link.mcap").symlink_to(path)

    async def work(service: RecordingService) -> None:
        with pytest.raises(RecordingError, match="there is no such recording"):
            await service.path("episode")
        (tmp_path / "link.mcap").unlink()
        named = path.rename(tmp_path / "My best round.mcap")
        assert await service.path("episode") == named
        assert json.loads((await service.replay("episode")).summary)["id"] == "episode"

    run(tmp_path, work)
