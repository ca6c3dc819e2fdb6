"""Finished recordings go to a bucket in the background; what could not be sent is sent later, also after a restart."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path

import pytest

from movingout.recordings.storage.s3_bucket import bucket_at, note_uploads
from movingout.server.persistence.recording_service import RecordingService
from movingout.server.persistence.recording_uploads import RecordingUploads
from movingout.study.data.erasure import remove_recordings
from movingout.study.errors import StudyError
from tests.recordings.support import record
from tests.s3_server import S3Server, s3_server
from tests.server.live import ADMIN, serve

ADDRESS = "s3://lab/rounds"


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> Iterator[S3Server]:
    with s3_server() as server:
        for name, value in server.environment.items():
            monkeypatch.setenv(name, value)
        bucket_at.cache_clear()
        yield server


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(60):
        while not condition():
            await asyncio.sleep(0.02)


def run(folder: Path, work: Callable[[RecordingService, RecordingUploads], Awaitable[None]]) -> None:
    """With both services, closed in the end.

    A file that the first comparison with the bucket meets before it is announced is sent twice: `sent` may be 2.
    """

    async def services() -> None:
        uploads = RecordingUploads(folder, ADDRESS, retry_s=(0.05,))
        service = RecordingService(folder, uploads.add)
        sending = asyncio.create_task(uploads.run())
        try:
            await work(service, uploads)
        finally:
            sending.cancel()
            await service.close()
            await uploads.close()

    asyncio.run(services())


def journal(folder: Path, name: str = "first") -> Path:
    return record(folder, ticks=3, map_name="LeftRight", episode_id=name)[0]


def test_a_finished_recording_is_sent_and_kept(store: S3Server, tmp_path: Path) -> None:
    async def work(service: RecordingService, uploads: RecordingUploads) -> None:
        service.finalise(journal(tmp_path))
        await until(lambda: uploads.sent > 0)

    run(tmp_path, work)
    [path] = tmp_path.glob("*.mcap")
    assert store.buckets["lab"] == {f"rounds/{path.name}": path.read_bytes()}


def test_while_the_store_refuses_recordings_wait_and_are_finished_all_the_same(
    store: S3Server, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    store.fails = "AccessDenied"

    async def work(service: RecordingService, uploads: RecordingUploads) -> None:
        await until(lambda: bool(uploads.problem))
        service.finalise(journal(tmp_path))
        service.finalise(journal(tmp_path, "second"))
        await service.settled()
        assert len(list(tmp_path.glob("*.mcap"))) == 2 and uploads.waiting == 2
        assert "the credentials have no right to do this" in uploads.problem
        store.fails = ""
        await until(lambda: uploads.sent == 2)
        assert (uploads.problem, uploads.waiting) == ("", 0)

    run(tmp_path, work)
    told = [record.message for record in caplog.records if record.levelname == "ERROR"]
    assert len(told) == 1 and told[0].startswith("recordings wait to be sent"), "once, not at each attempt"


@pytest.mark.slow
def test_after_a_restart_only_what_is_not_there_is_sent(store: S3Server, tmp_path: Path) -> None:
    async def first(service: RecordingService, uploads: RecordingUploads) -> None:
        service.finalise(journal(tmp_path))
        await until(lambda: uploads.sent > 0)

    async def later(service: RecordingService, uploads: RecordingUploads) -> None:
        await until(lambda: uploads.sent > 0)

    run(tmp_path, first)
    before = set(store.buckets["lab"])
    store.puts.clear()

    async def alone() -> None:  # a server that sends nothing
        service = RecordingService(tmp_path)
        service.finalise(journal(tmp_path, "second"))
        await service.close()

    asyncio.run(alone())
    run(tmp_path, later)
    assert set(store.puts) == set(store.buckets["lab"]) - before and len(store.puts) == 1


def test_who_is_forgotten_is_forgotten_there_too(store: S3Server, tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()

    async def work(service: RecordingService, uploads: RecordingUploads) -> None:
        service.finalise(journal(folder))
        await until(lambda: uploads.sent > 0)

    run(folder, work)
    note_uploads(tmp_path, ADDRESS)
    [path] = folder.glob("*.mcap")
    store.fails = "AccessDenied"
    with pytest.raises(StudyError, match="nothing is deleted yet, because copies are elsewhere"):
        remove_recordings(folder, "P1", {path.name.removesuffix(".mcap")})
    assert path.exists()
    store.fails = ""
    assert remove_recordings(folder, "P1", {path.name.removesuffix(".mcap")}) == 1
    assert store.buckets["lab"] == {} and not path.exists()


@pytest.mark.slow
def test_a_server_sends_and_measures_it(store: S3Server, tmp_path: Path) -> None:
    left = journal(tmp_path)
    with serve(tmp_path, s3=ADDRESS) as live:
        left.rename(tmp_path / "recordings" / left.name)
        live.run(lambda: live.host.recording_service.finalise(tmp_path / "recordings" / left.name))
        deadline = time.monotonic() + 60
        while not store.buckets["lab"] or live.host.uploads is None or not live.host.uploads.sent:
            assert time.monotonic() < deadline
            time.sleep(0.05)
        text = str(live.call("/metrics", token=ADMIN)[1])
        assert live.call("/api/admin/state", token=ADMIN)[1]["uploads"] == {"waiting": 0, "problem": ""}
    assert "movingout_recordings_uploaded_total 1.0" in text
    assert "movingout_recordings_not_uploaded 0.0" in text and "movingout_upload_failing 0.0" in text
