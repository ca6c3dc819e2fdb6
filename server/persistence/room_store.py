"""What a restart needs of each room: one small JSON file per room, written on every change.

One thread writes the newest state of each room and replaces its file atomically: after kill -9 the file is a few
milliseconds old at most. Of tokens it holds hashes only.
"""

import asyncio
import contextlib
import logging
import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from threading import Lock
from typing import Any

import msgspec

from movingout.recordings.storage.waiting_rounds import rounds_of_rooms
from movingout.server import messages as m
from movingout.server.notices import NoticeCode
from movingout.server.rooms.services import RoomConfig

log = logging.getLogger(__name__)

VERSION = 1
NOT_UNDERSTOOD = ".not-understood"  # behind the name of a file that is kept and not read again


class SeatFile(msgspec.Struct, forbid_unknown_fields=True):
    """One seat; token hashes in hexadecimal, empty for none."""

    kind: m.Kind
    agent_id: str
    shared: bool
    name: str
    alias: str
    token: str
    previous_token: str
    ready: bool
    gone: bool
    key: str = ""
    wants_again: bool = False


class RoomFile(msgspec.Struct, forbid_unknown_fields=True):
    """One room. `episode` names the journal of a round in progress."""

    version: int
    id: str
    saved: float  # wall clock [s], for people who look; clocks jump, so nothing is decided by it
    config: RoomConfig
    seats: list[SeatFile]
    phase: m.Phase
    reason: str
    index: int
    epoch: int
    episode: str
    results: list[m.Result]
    next_episode: str = ""  # of the round that has not begun
    joined: bool = True  # whether anybody ever came
    reason_code: NoticeCode = ""  # of `reason`, which is in English; none in files of before
    reason_values: dict[str, Any] = {}


class RoomStore:
    """The files of one folder; those of rooms of another study than this one, if it is named, are left alone."""

    def __init__(self, folder: Path, study: str = "") -> None:
        self._folder = folder
        self._study = study
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="room-store")
        self._lock = Lock()
        self._waiting: dict[str, bytes | None] = {}  # None: delete

    def save(self, room: RoomFile) -> None:
        """Write soon; only the newest state of a room is written."""
        self._queue(room.id, msgspec.json.encode(room))

    def delete(self, room_id: str) -> None:
        self._queue(room_id, None)

    def flush(self) -> None:
        """Wait until everything is written."""
        self._thread.submit(lambda: None).result()

    async def written(self) -> None:
        """Wait until everything is written that was to be kept before this call."""
        await asyncio.wrap_future(self._thread.submit(lambda: None))

    def close(self) -> None:
        self._thread.shutdown()

    def load(self, mine: Callable[[str], bool] = lambda room_id: True) -> Iterator[RoomFile]:
        """The rooms of the last run whose id is `mine`, however old; files that are not understood are set aside.

        An old room waits for its players like after a short restart, and closes when nobody comes. One that the disk
        does not give is left for the next start.
        """
        return self.load_from(self._folder, mine)

    def load_from(self, folder: Path, mine: Callable[[str], bool] = lambda room_id: True) -> Iterator[RoomFile]:
        """The same for another folder."""
        for path in sorted(folder.glob("*.json")):
            if not mine(path.stem):
                continue
            if (room := _read(path)) and not _is_of_another(room.config.study, self._study):
                yield room

    def _queue(self, room_id: str, content: bytes | None) -> "Future[None] | None":
        with self._lock:
            known = room_id in self._waiting
            self._waiting[room_id] = content
        return None if known else self._thread.submit(self._write, room_id)

    def _write(self, room_id: str) -> None:
        with self._lock:
            content = self._waiting.pop(room_id)
        path = self._path(room_id)
        try:
            if path is None:
                return
            if content is None:
                path.unlink(missing_ok=True)
            else:
                part = path.with_suffix(".tmp")
                part.write_bytes(content)
                os.replace(part, path)
        except OSError as error:
            log.error("the room %s would not survive a restart now: %s", room_id, error)

    def _path(self, room_id: str) -> Path | None:
        """The file of a room; None for one that is not to be kept here any more."""
        return self._folder / f"{room_id}.json"


def episodes_of_rooms(folder: Path) -> set[str]:
    """The rounds in progress that rooms go on with after the next start."""
    return {room.episode for room in rounds_of_rooms(folder)}


def episodes_of_other_studies(folder: Path, study: str) -> dict[str, str]:
    """The rounds in progress of other studies than this one, if it is named: the study's id by episode."""
    rooms = [room for room in rounds_of_rooms(folder) if _is_of_another(room.config.study, study)]
    return {room.episode: room.study for room in rooms}


def _is_of_another(names: Mapping[str, str], study: str) -> bool:
    return bool(study) and names.get("study", study) != study


def _read(path: Path) -> RoomFile | None:
    """The room; None for a file that is not understood, which is set aside, or that the disk does not give."""
    try:
        if not path.is_file():  # a pipe would never be read to its end
            log.error("%s is no plain file and is left out", path)
            return None
        room = msgspec.json.decode(path.read_bytes(), type=RoomFile)
        if room.version == VERSION:
            return room
    except OSError as error:
        log.error("the room file %s cannot be read: %s", path.name, error.strerror or error)
        return None
    except msgspec.MsgspecError:
        pass
    aside = path.with_name(path.name + NOT_UNDERSTOOD)
    with contextlib.suppress(OSError):
        path.replace(aside)
    log.warning("the room file %s is damaged or of another version: left out, and kept as %s", path.name, aside.name)
    return None
