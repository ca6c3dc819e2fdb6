"""The journal: an unchunked MCAP that grows by whole groups of records, one write and one checksum each.

A group is the head or one tick. It ends with a `/commit` message whose CRC-32 runs over every byte of the file so
far, so a torn tail is cut off at a tick and a flipped bit anywhere before it is found. A journal belongs to one
process at a time (a lock on the file itself), so that recovering never takes a running episode away; where a file
system has no locks, nobody sees to that.
"""

import contextlib
import io
import os
import re
import struct
import threading
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import orjson
from mcap.writer import Writer

from movingout.maps.files.data_sync import sync_data
from movingout.maps.files.file_lock import lock_file, unlock_file
from movingout.maps.files.input_file import open_input
from movingout.recordings.errors import BusyError, RecordingError, cannot
from movingout.recordings.file_format.records import MAGIC, RECORD
from movingout.recordings.file_format.topics import CHANNELS, COMMIT, JOURNAL_TOPICS

JOURNAL_SUFFIX = ".mcap.journal"
PROFILE = "movingout"
SLOW_S = 3.0  # a hiccup of a second makes one late tick; with more than this nobody can play
OPCODE_MESSAGE = 0x05
COMMIT_CHANNEL = CHANNELS[COMMIT.name]

_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_SEAL = struct.Struct("<QQ")  # tick, log time: what the commit says about itself
_COMMIT_START = b'{"commit":'
_COMMIT_MARK = re.compile(rb'\{"commit":\d')  # in no other record: quotes inside texts are escaped


def message(channel: int, sequence: int, log_ns: int, publish_ns: int, payload: bytes) -> bytes:
    """One MCAP message record (specification: opcode 0x05)."""
    return _MESSAGE.pack(OPCODE_MESSAGE, 22 + len(payload), channel, sequence, log_ns, publish_ns) + payload


def metadata_record(name: str, entries: Mapping[str, str]) -> bytes:
    """One MCAP metadata record."""
    stream, writer = _plain_writer()
    writer.add_metadata(name, dict(entries))
    return stream.getvalue()


def head(library: str, entries: Mapping[str, Mapping[str, str]], attachments: Mapping[str, bytes], at_ns: int) -> bytes:
    """Magic, header, metadata, attachments, schemas and channels: everything before the first message."""
    stream, writer = _plain_writer()
    writer.start(profile=PROFILE, library=library)
    for name, values in entries.items():
        writer.add_metadata(name, dict(values))
    for name, content in attachments.items():
        writer.add_attachment(at_ns, at_ns, name, "application/json", content)
    register(writer)
    writer.add_metadata("journal", {"note": "unfinished or being written; `movingout recordings recover` finishes it"})
    return stream.getvalue()


def register(writer: Writer) -> None:
    """Announce the truth topics and `/commit` under their fixed channel ids."""
    for topic in JOURNAL_TOPICS:
        schema = writer.register_schema(topic.schema_name, "jsonschema", orjson.dumps(topic.schema))
        if writer.register_channel(topic.name, "json", schema) != CHANNELS[topic.name]:
            raise AssertionError("channel ids are part of the format")


def _plain_writer() -> tuple[io.BytesIO, Writer]:
    stream = io.BytesIO()
    return stream, Writer(stream, use_chunking=False)


def _commit(tick: int, log_ns: int, offset: int, crc: int) -> bytes:
    seal = zlib.crc32(_SEAL.pack(tick, log_ns), crc)
    payload = b'%b%d,"offset":%d,"crc32":%d}' % (_COMMIT_START, tick, offset, seal)
    return message(COMMIT_CHANNEL, 0, log_ns, log_ns, payload)


# ---- reading -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class JournalScan:
    """How far a journal can be trusted: `data[:end]` is whole groups whose checksums hold."""

    end: int
    crc: int  # of data[:end]
    torn: int  # bytes after `end` that are the group in flight when the writer stopped
    damage: str  # one sentence when bytes changed after they were written, empty for none


def scan(data: bytes) -> JournalScan:
    """Walk the records and check every commit; stops at the first one that does not hold."""
    position, end, crc, ticks, broken = len(MAGIC), 0, 0, 0, False
    while data.startswith(MAGIC) and position + RECORD.size <= len(data):
        opcode, length = RECORD.unpack_from(data, position)
        after = position + RECORD.size + length
        if opcode == 0 or after > len(data):
            break
        if opcode == OPCODE_MESSAGE and data[position + 9 : position + 11] == COMMIT_CHANNEL.to_bytes(2, "little"):
            running = zlib.crc32(data[end:position], crc)
            tick = _held_commit(data[position:after], position, running)
            if tick is None:
                broken = True
                break
            end, crc, ticks = after, zlib.crc32(data[position:after], running), tick
        position = after
    # A write that was cut short leaves no commit behind it but, at most, the one it was in the middle of.
    if broken or _COMMIT_MARK.search(data, position + _MESSAGE.size + len(_COMMIT_START)):
        return JournalScan(
            end, crc, 0, f"bytes changed after they were written: nothing after tick {ticks} can be trusted"
        )
    return JournalScan(end, crc, len(data) - end, "")


def _held_commit(record: bytes, offset: int, crc: int) -> int | None:
    """The tick of a commit record that is byte for byte what it must be, else None."""
    try:
        _, _, _, _, log_ns, _ = _MESSAGE.unpack_from(record)
        tick = int(orjson.loads(record[_MESSAGE.size :])["commit"])
        expected = _commit(tick, log_ns, offset, crc)
    except (struct.error, ValueError, KeyError, TypeError):
        return None
    return tick if record == expected else None


# ---- writing -----------------------------------------------------------------------------------------------


class Journal:
    """An open journal file at its end.

    A disk that takes longer than SLOW_S for one group counts as an error, like a full one: the game goes on without it.
    """

    timer: Callable[[], float] = staticmethod(time.monotonic)

    def __init__(self, path: Path, descriptor: int, offset: int, crc: int) -> None:
        self.path = path
        self._descriptor = descriptor
        self._offset = offset
        self._crc = crc
        self._closing = threading.Lock()  # sync() runs in a thread

    @classmethod
    def create(cls, path: Path) -> "Journal":
        """A new, empty journal; never overwrites. Raises RecordingError."""
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise cannot("create", path, error) from error
        _lock(descriptor, path)
        return cls(path, descriptor, 0, 0)

    @classmethod
    def reopen(cls, path: Path) -> tuple["Journal", bytes, JournalScan]:
        """An existing journal, cut after its last whole group, with its bytes.

        Raises RecordingError, BusyError where another process writes it.
        """
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CLOEXEC)
        except OSError as error:
            raise cannot("open", path, error) from error
        with contextlib.ExitStack() as undo:
            undo.callback(os.close, descriptor)
            _lock(descriptor, path)
            data = path.read_bytes()
            found = scan(data)
            if found.damage or not found.end:
                raise RecordingError(f"cannot continue {path.name}: {found.damage or 'it has no complete header'}")
            os.ftruncate(descriptor, found.end)
            os.lseek(descriptor, found.end, os.SEEK_SET)
            undo.pop_all()
        return cls(path, descriptor, found.end, found.crc), data[: found.end], found

    def append(self, records: bytes, tick: int, log_ns: int) -> None:
        """Add one group: it survives the death of this process once this returns.

        Raises RecordingError, also for a disk that is too slow.
        """
        crc = zlib.crc32(records, self._crc)
        commit = _commit(tick, log_ns, self._offset + len(records), crc)
        group = records + commit
        started = self.timer()
        try:
            written = os.write(self._descriptor, group)
            while written < len(group):  # a nearly full disk takes a part first
                written += os.write(self._descriptor, group[written:])
        except OSError as error:
            with contextlib.suppress(OSError):  # leave whole groups only; scan() would cut it off as well
                os.ftruncate(self._descriptor, self._offset)
            raise cannot("write", self.path, error) from error
        self._crc = zlib.crc32(commit, crc)
        self._offset += len(group)
        if (took := self.timer() - started) > SLOW_S:
            raise RecordingError(
                f"the disk took {took:.1f} s for one tick of {self.path.name}; use a faster --data DIR"
            )

    def sync(self) -> None:
        """Make what was appended survive a power failure. Takes milliseconds: call it in a thread.

        Raises RecordingError.
        """
        with self._closing:
            if self._descriptor < 0:
                return
            copy = os.dup(self._descriptor)
        try:
            sync_data(copy)
        except OSError as error:
            raise cannot("sync", self.path, error) from error
        finally:
            os.close(copy)

    def close(self) -> None:
        with self._closing:
            if self._descriptor >= 0:
                unlock_file(self._descriptor)  # a copy inside sync() would keep it locked
                os.close(self._descriptor)
                self._descriptor = -1


def _lock(descriptor: int, path: Path) -> None:
    try:
        locked = lock_file(descriptor)
    except OSError as error:
        raise cannot("lock", path, error) from error
    if not locked:
        raise BusyError(f"{path.name} is being written by another process; wait until its episode ends")


@contextlib.contextmanager
def owned(path: Path) -> Iterator[bytes]:
    """The bytes of a journal that no process writes; it stays locked within the block.

    Raises RecordingError, BusyError where one writes it.
    """
    try:
        stream = open_input(path)
    except OSError as error:
        raise cannot("open", path, error) from error
    with stream:
        _lock(stream.fileno(), path)
        yield stream.read()


def remove_left(path: Path) -> None:
    """Remove a journal that a killed process left, if there is one. Raises BusyError for one that is being written."""
    if path.exists():
        with owned(path):
            path.unlink()
