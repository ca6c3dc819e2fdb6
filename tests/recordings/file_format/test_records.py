"""Indexes that name the same bytes again and again: what is read of a file stays as little as the file."""

import io
import struct

import pytest
from zstandard import compress

from movingout.recordings.file_format.records import (
    DATA_END,
    FOOTER,
    MAGIC,
    MESSAGE,
    RECORD,
    messages_since,
    metadata_in,
)

METADATA_INDEX, CHUNK_INDEX = 0x0D, 0x08


class CountingStream(io.BytesIO):
    """Bytes that know how many of them were read."""

    read_bytes = 0

    def read(self, size: int | None = -1) -> bytes:
        found = super().read(size)
        self.read_bytes += len(found)
        return found


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def record(opcode: int, body: bytes) -> bytes:
    return RECORD.pack(opcode, len(body)) + body


def metadata(name: str, value: str) -> bytes:
    entries = text("key") + text(value)
    return record(0x0C, text(name) + struct.pack("<I", len(entries)) + entries)


def indexed(data: bytes, opcode: int, index: bytes, groups: int) -> CountingStream:
    """A file of `data` whose end names the same index `groups` times."""
    summary = len(MAGIC) + len(data) + DATA_END.size
    offsets = record(0x0E, struct.pack("<BQQ", opcode, summary, len(index))) * groups
    footer = FOOTER.pack(0x02, 20, summary, summary + len(index), 0)
    return CountingStream(MAGIC + data + DATA_END.pack(0x0F, 4, 0) + index + offsets + footer + MAGIC)


def metadata_file(value: str, entries: int, groups: int) -> CountingStream:
    data = metadata("name", value)
    entry = record(METADATA_INDEX, struct.pack("<QQ", len(MAGIC), len(data)) + text("name"))
    return indexed(data, METADATA_INDEX, entry * entries, groups)


def test_metadata_are_found_by_the_index() -> None:
    assert metadata_in(metadata_file("value", entries=1, groups=1)) == {"name": {"key": "value"}}


def test_an_index_that_is_named_a_thousand_times_is_read_once() -> None:
    stream = metadata_file("value", entries=1000, groups=1000)
    assert metadata_in(stream) == {"name": {"key": "value"}}
    assert stream.read_bytes < 2 * len(stream.getvalue())


def test_a_record_that_is_named_a_thousand_times_is_refused() -> None:
    stream = metadata_file("value" * 10_000, entries=1000, groups=1)
    with pytest.raises(ValueError, match="its index names more bytes than there are"):
        metadata_in(stream)
    assert stream.read_bytes < 3 * len(stream.getvalue())


def test_the_chunks_of_a_file_share_what_they_may_take() -> None:
    """Each small chunk could be decompressed to 64 MB; a thousand of them are no recording."""
    contents = record(0x05, MESSAGE.pack(1, 0, 5, 5) + bytes(30 << 20))
    packed = compress(contents)
    head = struct.pack("<QQQI", 0, 5, len(contents), 0) + text("zstd") + struct.pack("<Q", len(packed))
    chunk = record(0x06, head + packed)
    entries = [
        struct.pack("<QQQQ", 0, 5, len(MAGIC) + number * len(chunk), len(chunk))
        + struct.pack("<IQ", 0, 0) + text("zstd") + struct.pack("<QQ", len(packed), len(contents))
        for number in range(4)
    ]  # fmt: skip
    stream = indexed(chunk * 4, CHUNK_INDEX, b"".join(record(CHUNK_INDEX, entry) for entry in entries), 1)
    messages = messages_since(stream, 0)
    assert [len(next(messages).data) for _ in range(2)] == [30 << 20] * 2
    with pytest.raises(ValueError, match="would take more memory than any recording"):
        list(messages)
