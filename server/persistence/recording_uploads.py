"""Sends finished recordings to an S3-compatible store, in a process of its own, so that no tick and no recording waits.

Nothing is deleted here. What is not there yet, of this run or an earlier one, is found by comparing the folder with
the bucket, so that a restart forgets nothing.
"""

import asyncio
import contextlib
import logging
from pathlib import Path

from movingout.recordings import RecordingError
from movingout.recordings.storage.s3_bucket import S3Bucket, not_uploaded, note_uploads, s3_address, upload
from movingout.server.persistence.work_process import WorkProcess

log = logging.getLogger(__name__)

COMPARE_S = 3600.0  # until folder and bucket are compared again: another node may have ended before it sent all
RETRY_S = (2.0, 10.0, 60.0, 300.0)  # after an upload failed; the last one again and again


def check_bucket(address: str, data: Path) -> None:
    """Raises RecordingError unless recordings can be written there; remembers the address in the data folder."""
    S3Bucket(s3_address(address)).check()
    try:
        note_uploads(data, address)
    except OSError as error:
        raise RecordingError(f"cannot write to {data}: {error.strerror or error}") from None


class RecordingUploads:
    """The uploads of one folder. Use inside a running event loop."""

    def __init__(self, folder: Path, address: str, retry_s: tuple[float, ...] = RETRY_S) -> None:
        self.folder, self.address = folder, address
        self.problem = ""  # of the newest attempt, empty when it succeeded
        self.sent = 0  # recordings, since the start
        self._waiting: dict[str, Path] = {}  # by name, oldest first
        self._compared = False
        self._news = asyncio.Event()
        self._retry_s = retry_s
        self._process = WorkProcess("sending recordings")

    @property
    def waiting(self) -> int:
        """Recordings that are known not to be there yet."""
        return len(self._waiting)

    @property
    def counts(self) -> tuple[int, int, bool]:
        """How many wait, how many were sent, and whether the last attempt failed."""
        return self.waiting, self.sent, bool(self.problem)

    def add(self, recording: Path) -> None:
        """A recording that has just been finished."""
        self._waiting[recording.name] = recording
        self._news.set()

    async def run(self) -> None:
        """Send whatever waits, for ever."""
        failures = 0
        while True:
            try:
                await self._send_all()
                failures = 0
            except RecordingError as error:
                if not failures:
                    log.error("recordings wait to be sent and are tried again: %s", error)
                self.problem = str(error)
                await asyncio.sleep(self._retry_s[min(failures, len(self._retry_s) - 1)])
                failures += 1
                continue
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._news.wait(), COMPARE_S)
                continue
            self._compared = False

    async def _send_all(self) -> None:
        """Raises RecordingError; what was not sent still waits."""
        if not self._compared:
            missing: list[Path] = await self._process.run(not_uploaded, self.folder, self.address)
            self._waiting |= {path.name: path for path in missing}
            self._compared = True
        self._news.clear()
        while self._waiting:
            name, path = next(iter(self._waiting.items()))
            del self._waiting[name]
            try:
                size: int = await self._process.run(upload, path, self.address)
            except BaseException:
                self._waiting[name] = path  # after the others: it may be this file that cannot be sent
                raise
            self.sent += size > 0
            if self.problem:
                log.warning("recordings are sent again")
            self.problem = ""

    async def close(self) -> None:
        """What still waits is found at the next start."""
        await self._process.close()
