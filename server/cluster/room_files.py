"""The files of rooms by shard and fencing token, so that a node that has lost a lease cannot touch them any more.

Rooms of the shard `k` lie in `rooms/k.17`, where 17 is the fencing token. Whoever takes the lease copies them into a
folder of its own token and replaces unfinished journals by copies: what the former node still writes goes into files
that have no name any more.
"""

import errno
import logging
import os
import re
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from movingout.maps.files.file_lock import is_locked
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server.cluster.errors import ClusterError
from movingout.server.cluster.shards import shard_of
from movingout.server.persistence.room_store import NOT_UNDERSTOOD, RoomFile, RoomStore
from movingout.server.security.tokens import new_id

log = logging.getLogger(__name__)

_FOLDER = re.compile(r"([a-z2-9])\.(\d+)")
FOLDER_ID = "cluster-folder"
GROWS_S = 1.0  # in which a round that is played writes into its journal


def folder_id(data: Path) -> str:
    """The name of a data folder, by which nodes know that they share it. Raises OSError."""
    path = data / FOLDER_ID
    data.mkdir(parents=True, exist_ok=True)
    part = data / f".{FOLDER_ID}-{new_id()}"
    part.write_text(new_id(20), encoding="ascii")
    try:
        os.link(part, path)  # of several nodes that start at once, one makes it
    except FileExistsError:
        pass
    finally:
        part.unlink()
    return path.read_text(encoding="ascii").strip()


class ShardedRoomStore(RoomStore):
    """`fence_of` says which fencing token a shard has here; of one that is not held here nothing is written."""

    def __init__(self, folder: Path, fence_of: Callable[[str], int | None]) -> None:
        super().__init__(folder)
        self._fence_of = fence_of

    def load_shard(self, shard: str, fence: int) -> Iterator[RoomFile]:
        """The rooms that `adopt` has brought."""
        return self.load_from(_place(self._folder, shard, fence))

    def _path(self, room_id: str) -> Path | None:
        fence = self._fence_of(shard_of(room_id))
        return None if fence is None else _place(self._folder, shard_of(room_id), fence) / f"{room_id}.json"


def has_rooms_of(rooms: Path, shard: str) -> bool:
    """Whether the files of a shard can be seen from here."""
    return bool(_folders(rooms, shard))


def has_files_of(rooms: Path, shard: str) -> bool:
    """Whether a room's file is there still: its deletion is queued, or the disk did not give it."""
    return any(file for folder in _folders(rooms, shard) for file in folder.glob("*.json"))


def shards_in(rooms: Path, recordings: Path) -> frozenset[str]:
    """The shards of which rooms or unfinished recordings were left here, by whomever; blocks for the disk.

    Without those with a recording that somebody may still be writing: a server that was forgotten, or, on a disk of
    several machines, a node of another database.
    """
    kept = [path for path in rooms.glob("*/*.json") if _FOLDER.fullmatch(path.parent.name)]
    journals = list(recordings.glob(f"*{JOURNAL_SUFFIX}"))
    written = _written(journals)
    left = {shard_of(path.name) for path in (*kept, *rooms.glob("*.json"), *journals)}
    return frozenset(left - written - {""})


def _written(journals: list[Path]) -> set[str]:
    """The shards of those that somebody has locked, or that grow: some disks have no locks."""
    before = {path: _size(path) for path in journals}
    if journals:
        time.sleep(GROWS_S)
    return {shard_of(path.name) for path in journals if _size(path) != before[path] or _in_use(path)}


def _size(journal: Path) -> int:
    """-1 for one that was finished meanwhile."""
    try:
        return journal.stat().st_size
    except OSError:
        return -1


def _in_use(journal: Path) -> bool:
    try:
        return is_locked(journal)
    except OSError as error:
        log.warning("%s is left alone: %s", journal.name, error.strerror or error)
        return True


def adopt(rooms: Path, recordings: Path, shard: str, fence: int) -> None:
    """Make the newest files of a shard those of this fencing token; blocks for the disk. Raises ClusterError."""
    try:
        _adopt_rooms(rooms, shard, fence)
        for file in rooms.glob(f"{shard}*.json"):  # of a server that was no node
            os.replace(file, _place(rooms, shard, fence) / file.name)
        for journal in journals_of(recordings, shard):
            _copy_in_place(journal)
    except OSError as error:
        raise ClusterError(f"the rooms of the shard {shard!r} cannot be read: {error.strerror or error}") from error


def journals_of(recordings: Path, shard: str) -> list[Path]:
    """The unfinished recordings of a shard."""
    return sorted(recordings.glob(f"{shard}*{JOURNAL_SUFFIX}"))


def discard(rooms: Path, shard: str, fence: int) -> None:
    """Forget a shard that was given back: it has no rooms. Files that were not understood are kept."""
    place = _place(rooms, shard, fence)
    try:
        for half in place.glob("*.tmp"):
            half.unlink(missing_ok=True)
        place.rmdir()
    except OSError as error:
        if error.errno not in (errno.ENOENT, errno.ENOTEMPTY, errno.EEXIST):
            log.warning("cannot remove %s: %s", place, error.strerror or error)


def _adopt_rooms(rooms: Path, shard: str, fence: int) -> None:
    """A new folder rather than a new name: on a network disk, another machine may go on writing under the old one."""
    earlier, place = _folders(rooms, shard), _place(rooms, shard, fence)
    if place in earlier:
        return  # they have been here all the time
    for left in rooms.glob(f"{shard}.*.part"):  # after a crash, of whatever token
        shutil.rmtree(left, ignore_errors=True)
    part = place.with_name(f"{place.name}.part")
    part.mkdir(parents=True)
    if earlier:
        for file in earlier[-1].iterdir():
            if file.name.endswith((".json", NOT_UNDERSTOOD)):
                shutil.copy2(file, part / file.name)
    os.replace(part, place)
    for old in earlier:
        shutil.rmtree(old, ignore_errors=True)


def _folders(rooms: Path, shard: str) -> list[Path]:
    """The folders of a shard, the newest last."""
    found = [(int(match[2]), path) for path in rooms.glob(f"{shard}.*") if (match := _FOLDER.fullmatch(path.name))]
    return [path for _, path in sorted(found)]


def _place(rooms: Path, shard: str, fence: int) -> Path:
    return rooms / f"{shard}.{fence}"


def _copy_in_place(journal: Path) -> None:
    part = journal.with_name(f".{journal.name}.{new_id()}")
    try:
        shutil.copy2(journal, part)
        os.replace(part, journal)
    except FileNotFoundError:
        log.info("%s was finished meanwhile", journal.name)
    finally:
        part.unlink(missing_ok=True)
