"""Turns a journal into a finished recording, in another process than the room's.

Copies the truth topics byte for byte, adds what can be derived (metrics, scene, transforms, log), compresses,
checksums everything and replaces atomically: at every moment either the journal or the recording is whole.
"""

import contextlib
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import orjson
from mcap.writer import CompressionType, Writer

from movingout.maps.files.file_lock import is_locked
from movingout.recordings.episode import Episode
from movingout.recordings.errors import BusyError, RecordingError, UnreadableError, cannot
from movingout.recordings.file_format.derived_topics import DerivedTopics, result
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX, PROFILE, owned, scan
from movingout.recordings.file_format.metadata import END, RECORDING, RESULT, header_metadata, utc
from movingout.recordings.file_format.reader import episode_of_journal, read_episode
from movingout.recordings.file_format.records import Message, records_of
from movingout.recordings.file_format.topics import CHANNELS, TRUTH
from movingout.recordings.storage.waiting_rounds import RoundInRoom, waiting_rounds
from movingout.world.metrics import to_numbers

SUFFIX = ".mcap"
DAMAGED_SUFFIX = ".damaged"
UNREADABLE_SUFFIX = ".unreadable"
_CHUNK_BYTES = 64 * 1024  # measured: 4 KiB costs 44 % more space, 1 MiB saves nothing


def finalise(journal: Path) -> Path:
    """The finished recording beside the journal, which is then deleted (kept as `.damaged` if bytes changed in it).

    Works on interrupted journals too: everything up to the last whole tick is kept and marked incomplete. Raises
    RecordingError, BusyError where the journal is being written.
    """
    with owned(journal) as data:
        found = scan(data)
        episode = episode_of_journal(data[: found.end], journal.name, found.damage)
        target = journal.with_name(f"{episode.header.episode_id}{SUFFIX}")
        if not _is_done(target, episode):
            with replacing(target) as stream:
                write_recording(stream, episode, data[: found.end], found.torn)
        _put_away(journal, bool(found.damage))
    return target


def write_recording(stream: IO[bytes], episode: Episode, journal: bytes, torn: int = 0) -> None:
    """Write a finished recording from an episode and the trusted bytes of its journal."""
    writer = Writer(
        stream, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD, enable_crcs=True, enable_data_crcs=True
    )
    writer.start(profile=PROFILE, library=f"movingout {episode.versions.get('movingout', 'unknown')}")
    for name, entries in header_metadata(episode.header, episode.versions).items():
        writer.add_metadata(name, entries)
    for name, content in episode.attachments.items():
        writer.add_attachment(episode.header.started_ns, episode.header.started_ns, name, "application/json", content)
    _register_truth(writer)
    messages = _copy(writer, journal, DerivedTopics(writer, episode))
    if episode.ended_ns:
        writer.add_metadata(END, {"outcome": episode.outcome, "ended_ns": str(episode.ended_ns)})
    writer.add_metadata(RESULT, {name: repr(value) for name, value in to_numbers(result(episode)).items()})
    writer.add_metadata(RECORDING, _closing(episode, messages, torn))
    writer.finish()  # type: ignore[no-untyped-call]


def _register_truth(writer: Writer) -> None:
    for topic in TRUTH:
        schema = writer.register_schema(topic.schema_name, "jsonschema", orjson.dumps(topic.schema))
        writer.register_channel(topic.name, "json", schema)


def _copy(writer: Writer, journal: bytes, derived: DerivedTopics) -> int:
    """Copy the truth messages, each followed by what is derived from it; the number copied."""
    truth = {CHANNELS[topic.name]: topic.name for topic in TRUTH}
    count = 0
    for record in records_of(journal):
        if isinstance(record, Message) and record.channel_id in truth:
            writer.add_message(record.channel_id, record.log_time, record.data, record.publish_time, record.sequence)
            derived.follow(truth[record.channel_id], record.log_time, record.publish_time)
            count += 1
    return count


def _closing(episode: Episode, messages: int, torn: int) -> dict[str, str]:
    """The metadata record that says how much there is and what is missing."""
    return {
        "complete": str(episode.complete).lower(),
        "outcome": episode.outcome,
        "ticks": str(len(episode.ticks)),
        "messages": str(messages),
        "torn_bytes": str(torn),
        "damage": episode.damage,
        "finalised_utc": utc(time.time_ns()),
    }


@contextlib.contextmanager
def replacing(target: Path) -> Iterator[IO[bytes]]:
    """A stream that replaces `target` atomically, or leaves nothing behind. Raises RecordingError."""
    part = target.with_name(target.name + ".tmp")
    try:
        with part.open("wb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(target)
        sync(target.parent)
    except OSError as error:
        raise cannot("write", target, error) from error
    finally:
        with contextlib.suppress(OSError):
            part.unlink()


def sync(path: Path) -> None:
    """Make a file, or the names in a folder, survive a power failure. Raises OSError."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _is_done(target: Path, episode: Episode) -> bool:
    """Whether an earlier attempt got as far as the rename, so that only the journal is left to put away."""
    if not target.exists():
        return False
    try:
        existing = read_episode(target)
    except UnreadableError as error:
        raise RecordingError(f"{target.name} is damaged, move it away and recover again ({error})") from error
    if existing.header != episode.header or len(existing.ticks) < len(episode.ticks):
        raise RecordingError(f"{target.name} exists already and is another episode; move one of the two away")
    return True


def _put_away(journal: Path, damaged: bool) -> None:
    try:
        if damaged:
            journal.replace(journal.with_name(journal.name + DAMAGED_SUFFIX))
        else:
            journal.unlink()
    except OSError as error:
        raise cannot("remove", journal, error) from error


# ---- recovery ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Recovery:
    """The outcome for one leftover journal, or for a damaged recording."""

    journal: Path  # or the recording
    recording: Path | None  # None when there was nothing to keep or it is in use
    ticks: int
    note: str  # one sentence
    failed: bool = False  # it is still there, and the note says what would help


def recover(folder: Path, also_waiting: bool = False) -> list[Recovery]:
    """Finish every leftover journal in a folder and below; unreadable ones are moved aside, running ones left alone.

    So are those of rounds that a server goes on with when it is started again, unless `also_waiting`. One that cannot
    be finished keeps nobody from the others.
    """
    journals = sorted(folder.rglob(f"*{JOURNAL_SUFFIX}"))
    waiting = {} if also_waiting else waiting_rounds(journals)
    return [_tried(journal, waiting.get(journal)) for journal in journals]


def _tried(journal: Path, waiting: RoundInRoom | None) -> Recovery:
    try:
        if waiting is not None and _is_free(journal):
            served = f"the study {waiting.study} is served" if waiting.study else "the server is started"
            note = f"left alone, because its round goes on when {served} again; --all ends it"
            return Recovery(journal, None, 0, note)
        return recover_journal(journal)
    except RecordingError as error:
        return Recovery(journal, None, 0, str(error), failed=True)


def _is_free(journal: Path) -> bool:
    """Whether no process writes it, as far as the disk says."""
    try:
        return not is_locked(journal)
    except OSError:
        return False


def recover_journal(journal: Path) -> Recovery:
    """Finish one leftover journal, whatever is in it; RecordingError on a disk error."""
    try:
        with owned(journal) as data:
            found = scan(data)
            episode_of_journal(data[: found.end], journal.name, found.damage)
    except BusyError:
        return Recovery(journal, None, 0, "being written by another process; left alone")
    except UnreadableError as error:
        return Recovery(journal, None, 0, f"nothing readable, moved aside as {_move_aside(journal)}: {error}")
    recording = finalise(journal)
    episode = read_episode(recording)
    note = episode.damage or ("whole" if episode.complete else f"interrupted after tick {len(episode.ticks)}")
    return Recovery(journal, recording, len(episode.ticks), note)


def _move_aside(journal: Path) -> str:
    aside = journal.with_name(journal.name + UNREADABLE_SUFFIX)
    try:
        return journal.replace(aside).name
    except OSError as error:
        raise cannot("move", journal, error) from error
