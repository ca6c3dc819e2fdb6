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
from movingout.server.background import BackgroundWork, reason
from movingout.server.host import Host
from movingout.server.persistence import fsync
from movingout.server.persistence.fsync import FEW, TRIED, sync_recordings, try_writing
from movingout.server.room_host import SYNC, FolderReplacedError
from movingout.server.settings import Settings
from tests.recordings.full_disk import limited
from tests.server.live import serve

pytestmark = pytest.mark.slow


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


def test_the_error_of_work_is_known_until_it_succeeds_again() -> None:
    found: list[str] = []

    async def run() -> None:
        work_of = BackgroundWork()

        async def work() -> None:
            error = work_of.error("saving")
            found.append("" if error is None else reason(error))
            if len(found) == 2:
                raise OSError(30, "Read-only file system", "/srv/secret")
            if len(found) == 3:
                raise RecordingError("cannot sync /srv/secret") from OSError(5, "Input/output error")

        work_of.repeat("saving", work, 0.001)
        while len(found) < 5:
            await asyncio.sleep(0.001)
        await work_of.stop()

    asyncio.run(run())
    assert found[:5] == ["", "", "Read-only file system", "Input/output error", ""]


def test_work_that_may_be_late_is_a_fault_only_while_it_fails() -> None:
    clock, failing = Clock(), asyncio.Event()

    async def work() -> None:
        if failing.is_set():
            raise OSError(30, "Read-only file system", "/srv/secret")

    async def run() -> list[list[str]]:
        work_of, found = BackgroundWork(clock), []
        work_of.repeat("writing", work, 0.001, may_be_late=True)
        clock.now += 119.0
        found.append([*work_of.faults()])
        await asyncio.sleep(0.02)
        failing.set()
        while work_of.error("writing") is None:
            await asyncio.sleep(0.001)
        clock.now += 4.0
        found.append([*work_of.faults()])
        clock.now += 2.0
        found.append([*work_of.faults()])
        failing.clear()
        while work_of.error("writing") is not None:
            await asyncio.sleep(0.001)
        found.append([*work_of.faults()])
        await work_of.stop()
        return found

    fault = "writing: not done for 6 s (Read-only file system)"
    assert asyncio.run(asyncio.wait_for(run(), 10.0)) == [[], [], [fault], []]


def test_work_that_may_be_late_and_hangs_is_a_fault_and_rounds_would_not_be_recorded(tmp_path: Path) -> None:
    clock, hangs = Clock(), asyncio.Event()
    host = Host(Settings(data=tmp_path))

    async def run() -> list[tuple[list[str], str]]:
        host.background, found = BackgroundWork(clock), []
        host.background.repeat(room_host.WRITING, hangs.wait, 30.0, may_be_late=True)  # type: ignore[arg-type]
        for seconds in (149.0, 2.0):
            clock.now += seconds
            found.append(([*host.background.faults()], host.process_health().unwritable))
        await host.background.stop()
        return found

    late = f"{room_host.WRITING}: not done for 151 s"
    assert asyncio.run(run()) == [([], ""), ([late], f"{room_host.WRITING}: the disk does not answer")]
    host.store.close()


def test_what_has_failed_is_tried_again_soon_however_seldom_it_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background, "AGAIN_S", 0.001)
    tries: list[int] = []

    async def work() -> None:
        tries.append(1)
        if len(tries) < 4:
            raise OSError(30, "Read-only file system")

    async def run() -> None:
        work_of = BackgroundWork()
        work_of.repeat("writing", work, 0.2)
        while len(tries) < 4:
            await asyncio.sleep(0.001)
        await work_of.stop()

    asyncio.run(asyncio.wait_for(run(), 0.6))


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
        while not host.process_health().unwritable:
            await asyncio.sleep(0.001)
        clock.now += 5.5
        reasons = [host.cannot_record().message, *host.faults()]
        await host.background.stop()
        host.store.close()
        return reasons

    assert asyncio.run(asyncio.wait_for(run(), 10.0)) == [
        "Rounds would not be recorded (writing to the folder of recordings: Read-only file system).",
        "writing to the folder of recordings: not done for 6 s (Read-only file system)",
    ]


def test_after_a_round_that_could_not_be_saved_the_folder_is_tried_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[Path] = []
    monkeypatch.setattr(room_host, "try_writing", tried.append)
    host = Host(Settings(data=tmp_path))
    host.settings.recordings.mkdir()
    host._recordings_id = room_host._folder_id(host.settings.recordings)
    asyncio.run(host._sync())
    assert tried == []
    monkeypatch.setattr(host.background, "error", lambda _: OSError(errno.EIO, "Input/output error"))
    asyncio.run(host._sync())
    assert tried == [host.settings.recordings]
    host.store.close()


def test_nothing_is_tried_while_rounds_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[Path] = []
    monkeypatch.setattr(room_host, "try_writing", tried.append)

    async def run() -> None:
        host = Host(Settings(data=tmp_path))
        monkeypatch.setattr(host, "_writers", lambda: [cast(EpisodeWriter, None)])
        await host._try_writing()
        assert tried == []
        monkeypatch.setattr(host, "_writers", list)
        await host._try_writing()
        host.store.close()

    asyncio.run(run())
    assert tried == [tmp_path / "recordings"]


def test_recordings_that_were_moved_away_are_a_fault(tmp_path: Path) -> None:
    with serve(tmp_path) as live:
        folder = live.host.settings.recordings
        live.run(lambda: None)
        folder.rename(tmp_path / "elsewhere")
        with pytest.raises(FileNotFoundError, match="the folder was moved away"):
            asyncio.run_coroutine_threadsafe(live.host._sync(), live.loop).result(10)
        folder.mkdir()
        with pytest.raises(FolderReplacedError, match="the folder was replaced"):
            asyncio.run_coroutine_threadsafe(live.host._sync(), live.loop).result(10)
        folder.rmdir()
        (tmp_path / "elsewhere").rename(folder)
        asyncio.run_coroutine_threadsafe(live.host._sync(), live.loop).result(10)


@pytest.mark.parametrize(
    ("error", "unwritable"),
    [
        (FileNotFoundError(errno.ENOENT, "the folder was moved away"), f"{SYNC}: the folder was moved away"),
        (FolderReplacedError(errno.ENOENT, "the folder was replaced"), ""),
        (None, ""),
    ],
)
def test_rounds_begin_in_a_folder_that_has_taken_the_place_of_another_and_not_in_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception | None, unwritable: str
) -> None:
    host = Host(Settings(data=tmp_path))
    monkeypatch.setattr(host.background, "error", lambda name: error if name == SYNC else None)
    monkeypatch.setattr(host.background, "age_s", lambda name: 1000.0)
    assert host.process_health().unwritable == unwritable, "however long it takes"
    host.store.close()
