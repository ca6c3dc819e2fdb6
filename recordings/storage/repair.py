"""Repair of a finished recording that was truncated or damaged: a broken copy, a failing disk.

Every chunk has a checksum of its own: only chunks whose checksum holds are used. What stands outside of chunks (names,
seats, the seed) is protected by the checksum at the end of the data alone; where that is missing, the repaired file
says that it could not be checked.
"""

import errno
import os
import shlex
import shutil
from dataclasses import dataclass, field
from pathlib import Path

from mcap.records import Attachment, Channel, Header, Metadata

from movingout.maps.files.input_file import open_input
from movingout.recordings.episode import Episode
from movingout.recordings.errors import RecordingError, UnreadableError
from movingout.recordings.file_format.journal import PROFILE, head, message
from movingout.recordings.file_format.metadata import END, Entries
from movingout.recordings.file_format.reader import (
    UNREADABLE,
    check_file,
    episode_of_journal,
    header_profile,
    read_bytes,
    read_episode,
)
from movingout.recordings.file_format.records import Message, Record, data_holds, records_of
from movingout.recordings.file_format.topics import CHANNELS
from movingout.recordings.storage.finished import DAMAGED_SUFFIX, SUFFIX, Recovery, replacing, write_recording
from movingout.recordings.storage.listing import read_metadata, recordings_below

TICK_ENDS = "/timing"  # the last message of each tick


def recover_recording(path: Path) -> Recovery:
    """Replace a finished recording by its intact part; the file as it was stays beside it as `.damaged`.

    An intact file is left alone. Raises RecordingError when nothing can be saved, or on a disk error.
    """
    data = read_bytes(path)
    try:
        check_file(data, path.name)
    except UnreadableError:
        if header_profile(data) != PROFILE:
            raise
    else:
        return Recovery(path, path, len(read_episode(path).ticks), "whole; left as it is")
    episode, journal = repair(data, path.name)
    with replacing(path) as stream:
        write_recording(stream, episode, journal)
        _keep_beside(path)
    return Recovery(path, path, len(episode.ticks), episode.damage or "only its index was lost; whole again")


def damaged_below(folder: Path) -> list[Recovery]:
    """The recordings in a folder and below whose index cannot be read, each with the command that saves its whole part.

    They are left as they are. Raises RecordingError for a folder that cannot be listed.
    """
    found = [(path, _damage(path)) for path in recordings_below(folder) if path.name.endswith(SUFFIX)]
    return [Recovery(path, None, 0, problem, failed=True) for path, problem in found if problem]


def _damage(path: Path) -> str:
    """What is wrong with a recording of ours, and what would help; empty for an intact one, and for other files."""
    try:
        read_metadata(path)
        return ""
    except RecordingError as error:
        problem = str(error)
    try:
        with open_input(path) as stream:
            ours = header_profile(stream.read(4096)) == PROFILE
    except OSError:
        return problem
    command = f"movingout recordings recover {shlex.quote(str(path))}"
    return f"incomplete or damaged; save what is whole: {command}" if ours else ""


def repair(data: bytes, name: str) -> tuple[Episode, bytes]:
    """The episode up to its last whole tick, and the journal that holds just that. Raises UnreadableError."""
    found = _IntactRecords(whole=data_holds(data))
    try:
        for record in records_of(data, checked=True):
            found.take(record)
    except UNREADABLE:
        pass  # what came before is as it was written
    journal, ticks = found.journal()
    damage = f"saved from a torn or damaged file up to tick {ticks}; its names, seats and settings could not be checked"
    return episode_of_journal(journal, name, "" if found.whole else damage), journal


@dataclass
class _IntactRecords:
    """The records of a file that are intact; `whole` when all data are, and only the index behind them is not."""

    whole: bool
    library: str = ""
    metadata: dict[str, Entries] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    topics: dict[int, str] = field(default_factory=dict)  # by channel
    messages: list[tuple[str, Message]] = field(default_factory=list)

    def take(self, record: Record) -> None:
        match record:
            case Message():
                if (topic := self.topics[record.channel_id]) in CHANNELS:
                    self.messages.append((topic, record))
            case Channel():
                self.topics[record.id] = record.topic
            case Metadata():
                self.metadata[record.name] = record.metadata
            case Attachment():
                self.attachments[record.name] = record.data
            case Header():
                self.library = record.library

    def journal(self) -> tuple[bytes, int]:
        """Everything, or what belongs to whole ticks, as a journal without checksums; and the number of ticks."""
        ends = [index for index, (topic, _) in enumerate(self.messages) if topic == TICK_ENDS]
        kept = self.messages if self.whole or not ends else self.messages[: ends[-1] + 1]
        entries = {name: values for name, values in self.metadata.items() if self.whole or name != END}
        first = head(self.library, entries, self.attachments, 0)
        written = [
            message(CHANNELS[topic], one.sequence, one.log_time, one.publish_time, one.data) for topic, one in kept
        ]
        return b"".join([first, *written]), len(ends)


def _keep_beside(path: Path) -> None:
    """Link the file under a second name, so that it cannot be lost at any moment. Raises OSError."""
    aside = path.with_name(path.name + DAMAGED_SUFFIX)
    if aside.exists():
        raise FileExistsError(errno.EEXIST, f"{aside.name} is there already", str(aside))
    try:
        os.link(path, aside)
    except OSError:  # a file system without hard links
        shutil.copy2(path, aside)
