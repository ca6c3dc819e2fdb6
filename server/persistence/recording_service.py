"""The recordings of a server, in two other processes, so that no tick is late: one finishes journals, the other lists
and replays recordings, so that whoever asks for replays delays nobody's recording.

Knows no room. Ids are unguessable, so one recording needs no token; a path is that of an id, never of a name or link.
"""

import asyncio
import logging
import time
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import orjson

from movingout.recordings import RecordingError, browser_replay, finalise
from movingout.recordings.file_format.metadata import EPISODE_ID
from movingout.recordings.storage.finished import SUFFIX, Recovery, recover_journal
from movingout.recordings.storage.index import list_recordings, renamed_file
from movingout.recordings.storage.listing import Summary
from movingout.server import messages as m
from movingout.server.persistence.work_process import WorkProcess
from movingout.server.rooms.ghost_partner import GhostSeat, ghost_seat

Result = TypeVar("Result")
log = logging.getLogger(__name__)

CACHED_REPLAYS = 8
RETRY_S = (2.0, 10.0, 60.0, 600.0)  # after a journal could not be finished; the last one again and again
CLOSE_S = 10.0  # for journals that wait when the server ends; service managers kill it after 30 s


class ReplayFiles(NamedTuple):
    """What the browser needs to show a recording again."""

    summary: bytes  # JSON
    poses: bytes  # int16, little endian, (1 + 5 T, 2 + N, 3) with the wire's scales
    decision_traces: bytes  # JSON


class KeptReplay(NamedTuple):
    """A replay in memory, and the file that it was made from, as it was then."""

    files: ReplayFiles
    path: Path
    stamp: tuple[int, int]  # size and time of the last change in ns; (0, 0) of a file that is gone


class RecordingService:
    """The recordings of one folder. Use inside a running event loop.

    `address` says, as limits know it, for whom something is read: addresses take turns.
    """

    def __init__(
        self,
        folder: Path,
        on_finished: Callable[[Path], None] = lambda recording: None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.folder = folder
        self._clock = clock
        self._on_finished = on_finished
        self.unfinished: dict[str, str] = {}  # why, by journal name
        self._finishing = WorkProcess("finishing recordings")
        self._reading = WorkProcess("reading recordings")
        self._pending: dict[str, asyncio.Task[None]] = {}  # by journal name
        self._last_done = 0.0  # with a journal, or when the first of those that are pending came
        self._retries: dict[str, asyncio.TimerHandle] = {}
        self._replays: OrderedDict[str, KeptReplay] = OrderedDict()
        self._being_read: dict[str, asyncio.Task[ReplayFiles]] = {}

    @property
    def pending(self) -> int:
        """Journals being finalised."""
        return len(self._pending)

    @property
    def stands_still_s(self) -> float:
        """For how long no journal that is being finalised is done with, as on a disk that hangs."""
        return self._clock() - self._last_done if self._pending else 0.0

    def knows(self, journal: Path) -> bool:
        """Whether a journal is being finished, or will be tried again."""
        return journal.name in self._pending or journal.name in self._retries

    def finalise(self, journal: Path) -> None:
        """Turn a closed journal into a recording, in the background."""
        self._begin(journal, finalise)

    def recover(self, journal: Path) -> None:
        """The same for a journal that somebody left behind; an unreadable one is moved aside."""
        self._begin(journal, recover_journal)

    async def listing(self) -> bytes:
        """{"recordings": one line per finished recording, newest first} as JSON: written where it delays no tick."""
        document: bytes = await self._reading.run(_list, self.folder)
        return document

    def has_replay(self, episode_id: str) -> bool:
        """Whether a replay costs nothing more."""
        return self._kept(episode_id) is not None or episode_id in self._being_read

    async def replay(self, episode_id: str, address: str = "") -> ReplayFiles:
        """Raises RecordingError when there is no such recording or it cannot be read."""
        if kept := self._kept(episode_id):
            self._replays.move_to_end(episode_id)
            return kept
        if episode_id not in self._being_read:  # whoever asks meanwhile waits for the same
            task = asyncio.create_task(self._read_replay(episode_id, address))
            self._being_read[episode_id] = task
            task.add_done_callback(lambda _: self._being_read.pop(episode_id, None))
        return await asyncio.shield(self._being_read[episode_id])

    async def _read_replay(self, episode_id: str, address: str) -> ReplayFiles:
        path = await self.path(episode_id, address=address)
        stamp = _stamp(path)
        files = ReplayFiles(*await self._reading.run(_replay, path, address=address))
        self._replays[episode_id] = KeptReplay(files, path, stamp)
        while len(self._replays) > CACHED_REPLAYS:
            self._replays.popitem(last=False)
        return files

    def _kept(self, episode_id: str) -> ReplayFiles | None:
        """What is in memory, but of a file that was changed or deleted since: who played may have asked for that."""
        kept = self._replays.get(episode_id)
        if kept is not None and _stamp(kept.path) != kept.stamp:
            del self._replays[episode_id]
            return None
        return kept.files if kept is not None else None

    async def path(self, episode_id: str, urgent: bool = False, address: str = "") -> Path:
        """The file of a recording, waiting for it to be finalised. Raises RecordingError when there is none.

        ReadersBusy, unless it is `urgent`, where it has to be looked for and too many are waiting for that.
        """
        if not EPISODE_ID.fullmatch(episode_id):
            raise RecordingError("a recording's id has up to 80 letters, digits, '-' and '_'")
        pending = self._pending.get(f"{episode_id}.mcap.journal")
        if pending is not None:
            await asyncio.shield(pending)
        path = self.folder / f"{episode_id}{SUFFIX}"
        if not path.is_file():
            renamed = self._reading.run(_renamed, self.folder, episode_id, urgent=urgent, address=address)
            path = await renamed or path
        if path.is_symlink() or not path.is_file():
            raise RecordingError("there is no such recording; it may still be running or may have been deleted")
        return path

    async def read(
        self, episode_id: str, work: Callable[[Path], Result], urgent: bool = False, address: str = ""
    ) -> Result:
        """What `work` finds in a recording, in the other process. Raises RecordingError, ReadersBusy as `path` does."""
        path = await self.path(episode_id, urgent, address)
        found: Result = await self._reading.run(work, path, urgent=urgent, address=address)
        return found

    async def compute(self, work: Callable[[], Result], urgent: bool = False) -> Result:
        """What `work` finds, in the other process. Raises RecordingError; ReadersBusy, unless it is `urgent`."""
        found: Result = await self._reading.run(work, urgent=urgent)
        return found

    async def ghost_seat(self, ghost: str, address: str = "") -> GhostSeat:
        """What a room for the ghost `FILE#red` has to play. Raises RecordingError."""
        found: GhostSeat = await self._reading.run(ghost_seat, ghost, address=address)
        return found

    async def settled(self) -> None:
        """Wait until every journal is finalised."""
        await asyncio.gather(*self._pending.values(), return_exceptions=True)

    async def close(self) -> None:
        """Finish what can be within CLOSE_S, and stop the processes. The others stay journals until the next start."""
        for handle in self._retries.values():
            handle.cancel()
        if self._pending:
            await asyncio.wait(self._pending.values(), timeout=CLOSE_S)
        left = list(self._pending.values())
        if left:
            log.warning("%d recordings stay journals; the next start finishes them", len(left))
        for task in left:
            task.cancel()
        await asyncio.gather(self._finishing.close(), self._reading.close(), *left, return_exceptions=True)

    def _begin(self, journal: Path, work: Any, attempt: int = 0) -> None:
        self._retries.pop(journal.name, None)
        if not self._pending:
            self._last_done = self._clock()
        task = asyncio.create_task(self._finish(journal, work, attempt))
        self._pending[journal.name] = task
        task.add_done_callback(lambda _: self._pending.pop(journal.name, None))

    async def _finish(self, journal: Path, work: Any, attempt: int) -> None:
        try:
            done: Path | Recovery = await self._finishing.run(work, journal, urgent=True)
            self.unfinished.pop(journal.name, None)
            recording = done.recording if isinstance(done, Recovery) else done
            if recording is not None:
                self._on_finished(recording)
        except (RecordingError, OSError) as error:
            if journal.parent.is_dir() and not journal.exists():
                # another node that shares the folder was faster, or whoever played has asked for the deletion
                self.unfinished.pop(journal.name, None)
                return
            log.error("the recording %s stays a journal for now: %s", journal.name, error)
            self._try_later(journal, work, attempt, error)
        except Exception as error:  # of any kind: the journal is whole, and another time may succeed
            log.exception("the recording %s stays a journal for now", journal.name)
            self._try_later(journal, work, attempt, error)
        finally:
            self._last_done = self._clock()

    def _try_later(self, journal: Path, work: Any, attempt: int, error: Exception) -> None:
        self.unfinished[journal.name] = str(error)
        delay = RETRY_S[min(attempt, len(RETRY_S) - 1)]
        loop = asyncio.get_running_loop()
        self._retries[journal.name] = loop.call_later(delay, self._begin, journal, work, attempt + 1)


def _stamp(path: Path) -> tuple[int, int]:
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_size, found.st_mtime_ns


def _renamed(folder: Path, episode_id: str) -> Path | None:
    return renamed_file(folder, episode_id, running=False)


def _list(folder: Path) -> bytes:
    found, unreadable = list_recordings(folder, running=False)
    rows = [_row(entry) for entry in found]
    rows += [
        {"id": entry.path.name.removesuffix(SUFFIX), "started": "", "complete": False, "damage": entry.problem}
        for entry in unreadable
    ]
    return orjson.dumps({"recordings": rows})


def _row(entry: Summary) -> dict[str, Any]:
    row = entry.to_json()
    del row["path"]
    return row


def _replay(path: Path) -> tuple[bytes, bytes, bytes]:
    summary, frames, traces = browser_replay(path, m.POSITION_SCALE, m.ANGLE_SCALE)
    return orjson.dumps(summary), frames.astype("<i2").tobytes(), orjson.dumps({"thoughts": traces})
