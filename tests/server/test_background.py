"""Background work survives its errors, and a server tells when it does not succeed."""

import asyncio
import ctypes
import errno
import logging
from pathlib import Path
from typing import NoReturn, cast

import pytest

from movingout.recordings import EpisodeWriter, RecordingError
from movingout.server import background, room_host
from movingout.server.background import BackgroundWork
from movingout.server.host import Host
from movingout.server.persistence import fsync
from movingout.server.persistence.fsync import FEW, TRIED, sync_recordings, try_writing
from movingout.server.settings import Settings
from tests.recordings.full_disk import limited
from tests.server.live import serve


class Clock:
    """A clock that only moves when told to."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_work_that_fails_is_done_again_and_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    done: list[int] = []

    async def work() -> None:
        done.append(len(done))
        if len(done) < 4:
            raise OSError(24, "Too many open files")

    async def run() -> list[str]:
        work_of = BackgroundWork()
        work_of.repeat("saving", work, 0.001)
        while len(done) < 6:
            await asyncio.sleep(0.001)
        faults = [*work_of.faults()]
        await work_of.stop()
        return faults

    assert asyncio.run(run()) == []
    assert [record.getMessage() for record in caplog.records if record.levelno == logging.ERROR] == [
        "saving failed and is tried again: [Errno 24] Too many open files"
    ]


def test_work_that_failed_once_does_not_work_until_it_succeeds_again() -> None:
    found: list[bool] = []

    async def run() -> None:
        work_of = BackgroundWork()

        async def work() -> None:
            found.append(work_of.works("saving"))
            if len(found) == 2:
                raise OSError(30, "Read-only file system")

        work_of.repeat("saving", work, 0.001)
        while len(found) < 4:
            await asyncio.sleep(0.001)
        await work_of.stop()

    asyncio.run(run())
    assert found[:4] == [True, True, False, True]


def test_work_that_never_succeeds_is_a_fault_after_five_seconds() -> None:
    async def run() -> tuple[list[str], list[str]]:
        clock = Clock()
        work_of = BackgroundWork(clock)
        work_of.repeat("saving", asyncio.Event().wait, 1.0)  # type: ignore[arg-type]
        clock.now += 5.9
        before = [*work_of.faults()]
        clock.now += 0.2
        after = [*work_of.faults()]
        await work_of.stop()
        return before, after

    assert asyncio.run(run()) == ([], ["saving: not done for 6 s"])


def test_work_that_ends_is_begun_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background, "RETRY_S", 0.0)
    begun: list[int] = []

    async def work() -> None:
        begun.append(1)
        raise RuntimeError("once")

    async def run() -> None:
        work_of = BackgroundWork()
        work_of.keep_running("the clock", work)
        while len(begun) < 3:
            await asyncio.sleep(0.001)
        await work_of.stop()

    asyncio.run(run())


def test_a_disk_that_fails_for_long_is_a_fault_of_the_server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def fails(self: Host) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(Host, "_sync", fails)
    monkeypatch.setattr(background, "OVERDUE_S", -0.9)
    with serve(tmp_path) as live:
        live.open_room("here", "idle")
        for _ in range(200):
            status, answer = live.call("/healthz")
            if status == 503:
                break
        assert (status, answer["ok"]) == (503, False)
        assert answer["faults"][0].startswith("saving recordings to the disk: not done for ")


def test_a_file_that_cannot_be_forced_to_the_disk_is_no_success_and_the_others_are_tried(tmp_path: Path) -> None:
    tried: list[int] = []

    class Writer:
        def sync(self) -> None:
            tried.append(len(tried))
            if len(tried) == 1:
                raise RecordingError("cannot sync: Input/output error")

    with pytest.raises(RecordingError, match="Input/output error"):
        sync_recordings(tmp_path, [cast(EpisodeWriter, Writer())] * (FEW - 1))
    assert len(tried) == FEW - 1


def test_a_file_system_that_cannot_be_forced_to_the_disk_is_no_success(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(descriptor: int) -> int:
        ctypes.set_errno(errno.ENOSPC)
        return -1

    monkeypatch.setattr(fsync, "_SYNCFS", full)
    with pytest.raises(OSError, match="No space left"):
        sync_recordings(tmp_path, [cast(EpisodeWriter, None)] * (FEW + 1))


def test_a_folder_is_tried_without_a_file_that_anybody_sees(tmp_path: Path) -> None:
    try_writing(tmp_path)
    assert list(tmp_path.iterdir()) == []
    with limited(TRIED // 2), pytest.raises(OSError, match="File too large"):
        try_writing(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_takes_no_writing_while_nobody_plays_is_a_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read_only(folder: Path) -> NoReturn:
        raise OSError(errno.EROFS, "Read-only file system", str(folder))

    monkeypatch.setattr(room_host, "try_writing", read_only)
    monkeypatch.setattr(room_host, "WRITING_S", 0.001)
    clock = Clock()

    async def run() -> list[str]:
        host = Host(Settings(data=tmp_path))
        host.settings.recordings.mkdir()
        host.background = BackgroundWork(clock)
        assert not host.cannot_record()
        await host.start_rooms()
        while host.process_health().records:
            await asyncio.sleep(0.001)
        clock.now += 5.5
        reasons = [host.cannot_record().message, *host.faults()]
        await host.background.stop()
        host.store.close()
        return reasons

    assert asyncio.run(asyncio.wait_for(run(), 10.0)) == [
        "Nothing can be written to the server's folder of recordings.",
        "writing to the folder of recordings: not done for 6 s",
    ]


def test_recordings_that_were_moved_away_are_a_fault(tmp_path: Path) -> None:
    with serve(tmp_path) as live:
        folder = live.host.settings.recordings
        live.run(lambda: None)
        folder.rename(tmp_path / "elsewhere")
        with pytest.raises(FileNotFoundError, match="moved away or replaced"):
            asyncio.run_coroutine_threadsafe(live.host._sync(), live.loop).result(10)
        folder.mkdir()
        with pytest.raises(FileNotFoundError, match="moved away or replaced"):
            asyncio.run_coroutine_threadsafe(live.host._sync(), live.loop).result(10)
        folder.rmdir()
        (tmp_path / "elsewhere").rename(folder)
        asyncio.run_coroutine_threadsafe(live.host._sync(), live.loop).result(10)
