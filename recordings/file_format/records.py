"""The records inside an MCAP, in file order: a tenth of the cost of the library's general stream reader.

Only what our recordings can hold is decoded; unknown records are skipped, as the MCAP specification asks.
The bytes are trusted: callers verify checksums first (`reader.check_file`, `journal.scan`).
"""

import io
import struct
import zlib
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple, TypeVar

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Header,
    Metadata,
    MetadataIndex,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time; then the payload
RECORD = struct.Struct("<BQ")  # opcode, length
DATA_END = struct.Struct("<BQI")  # opcode, length, crc
FOOTER = struct.Struct("<BQQQI")  # opcode, length, summary start, summary offset start, crc
_FOOTER, _CHUNK_INDEX, _ATTACHMENT_INDEX, _METADATA_INDEX, _SUMMARY_OFFSET = 0x02, 0x08, 0x0A, 0x0D, 0x0E
_HEADER, _CHANNEL, _MESSAGE, _CHUNK, _ATTACHMENT, _METADATA, _DATA_END = 0x01, 0x04, 0x05, 0x06, 0x09, 0x0C, 0x0F


Entry = TypeVar("Entry", AttachmentIndex, ChunkIndex, MetadataIndex, SummaryOffset)
Indexed = TypeVar("Indexed", AttachmentIndex, ChunkIndex, MetadataIndex)


class Message(NamedTuple):
    """One message on a channel."""

    channel_id: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


Record = Header | Channel | Message | Attachment | Metadata


MOST_PER_BYTE, ALWAYS_POSSIBLE = 200, 64 << 20  # decompressed bytes; ours are ten to thirty times as large


class _Budget:
    """What the chunks of one file may take when they are decompressed: a few bytes must not fill the memory."""

    def __init__(self, size: int) -> None:
        self._left = ALWAYS_POSSIBLE + MOST_PER_BYTE * size

    def decompressed(self, chunk: Chunk) -> bytes:
        """The contents of a chunk. Raises ZstdError when it is damaged.

        ValueError when there is too much in it, or when it is compressed in another way: other tools write lz4.
        """
        if not chunk.compression:
            return bytes(chunk.data)
        if chunk.compression != "zstd":
            raise ValueError(f"its chunks are compressed as {chunk.compression!r:.20}, not as 'zstd'; convert it")
        size = max(chunk.uncompressed_size, zstandard.frame_content_size(chunk.data))
        if size > self._left:
            raise ValueError("its chunks would take more memory than any recording")
        self._left -= size
        return zstandard.decompress(chunk.data, chunk.uncompressed_size)


def records_of(data: bytes, checked: bool = False) -> Iterator[Record]:
    """The records of a file or journal up to its data end; a journal ends where its bytes end.

    `checked` is for finished files whose checksum is wrong: reading ends at the first chunk or attachment whose own
    checksum is wrong too, and messages outside of chunks are ignored. Raises as `metadata_in` does.
    """
    yield from _walk(data, len(MAGIC), checked, _Budget(len(data)))


def data_holds(data: bytes) -> bool:
    """Whether everything up to the data end is as it was written; what follows there is only an index."""
    position = len(MAGIC)
    while position + RECORD.size <= len(data):
        opcode, length = RECORD.unpack_from(data, position)
        if opcode == _DATA_END:
            return data[position : position + DATA_END.size] == DATA_END.pack(_DATA_END, 4, zlib.crc32(data[:position]))
        position += RECORD.size + length
    return False


def _walk(data: bytes, position: int, checked: bool, budget: _Budget, in_chunk: bool = False) -> Iterator[Record]:
    while position + RECORD.size <= len(data):
        opcode, length = RECORD.unpack_from(data, position)
        start, position = position + RECORD.size, position + RECORD.size + length
        if opcode == _DATA_END or position > len(data):
            return
        if checked and opcode == _ATTACHMENT and data[position - 4 : position] != _crc(data[start : position - 4]):
            return
        if opcode == _MESSAGE and not checked:
            channel, sequence, log_time, publish_time = MESSAGE.unpack_from(data, start)
            yield Message(channel, sequence, log_time, publish_time, data[start + MESSAGE.size : position])
        elif opcode == _CHUNK:
            if in_chunk:
                raise ValueError("a chunk is in a chunk, which MCAP forbids")
            chunk = Chunk.read(_stream(data[start:position]))
            contents = budget.decompressed(chunk)
            if checked and zlib.crc32(contents) != chunk.uncompressed_crc:
                return
            yield from _walk(contents, 0, False, budget, in_chunk=True)
        elif opcode in _READERS:
            yield _READERS[opcode].read(_stream(data[start:position]))


def _crc(content: bytes) -> bytes:
    return zlib.crc32(content).to_bytes(4, "little")


def metadata_in(stream: BinaryIO) -> dict[str, dict[str, str]]:
    """The metadata records of a finished file, found by its index: a dozen short reads however long the file is.

    Raises ValueError or an error of struct or mcap when the end of the file is not that of a whole MCAP.
    """
    found: dict[str, dict[str, str]] = {}
    for entry in _index(stream, _METADATA_INDEX, MetadataIndex):
        record = Metadata.read(_stream(_read(stream, entry.offset, entry.length)[RECORD.size :]))
        found[record.name] = record.metadata
    return found


def messages_since(stream: BinaryIO, log_time: int) -> Iterator[Message]:
    """The messages of a finished file from a log time on: the index tells which chunks have them.

    Raises ZstdError, ValueError or an error of struct or mcap where they, or the end of the file, are not whole.
    """
    budget = _Budget(stream.seek(0, io.SEEK_END))
    for entry in _index(stream, _CHUNK_INDEX, ChunkIndex):
        if entry.message_end_time >= log_time:
            chunk = _read(stream, entry.chunk_start_offset, entry.chunk_length)
            for record in _walk(chunk, 0, False, budget):
                if isinstance(record, Message) and record.log_time >= log_time:
                    yield record


def attachment_in(stream: BinaryIO, name: str, limit: int) -> bytes | None:
    """An attachment of a finished file, found by its index; None where there is none of at most `limit` bytes.

    Raises ValueError or an error of struct or mcap, as `metadata_in`.
    """
    for entry in _index(stream, _ATTACHMENT_INDEX, AttachmentIndex):
        if entry.name == name and entry.length <= limit:
            data: bytes = Attachment.read(_stream(_read(stream, entry.offset, entry.length)[RECORD.size :])).data
            return data
    return None


def _index(stream: BinaryIO, opcode: int, kind: type[Indexed]) -> Iterator[Indexed]:
    """The entries of one kind in the index at the end of a file.

    ValueError where they name more bytes than the file has, as entries of the same place do: a small file could
    otherwise name itself thousands of times.
    """
    left = stream.seek(0, io.SEEK_END)
    end = max(left - FOOTER.size - len(MAGIC), 0)
    tail = _read(stream, end, FOOTER.size + len(MAGIC))
    footer, _, summary, offsets, _ = FOOTER.unpack_from(tail)
    if footer != _FOOTER or not tail.endswith(MAGIC) or not 0 < summary < offsets < end:
        raise ValueError("no whole footer")
    for group in _entries(_read(stream, offsets, end - offsets), _SUMMARY_OFFSET, SummaryOffset):
        if group.group_opcode == opcode:
            for entry in _entries(_read(stream, group.group_start, group.group_length), opcode, kind):
                left -= entry.chunk_length if isinstance(entry, ChunkIndex) else entry.length
                if left < 0:
                    raise ValueError("its index names more bytes than there are")
                yield entry
            return  # MCAP has one group of a kind


def _entries(section: bytes, wanted: int, kind: type[Entry]) -> Iterator[Entry]:
    position = 0
    while position < len(section):
        opcode, length = RECORD.unpack_from(section, position)
        start, position = position + RECORD.size, position + RECORD.size + length
        if opcode == wanted:
            yield kind.read(_stream(section[start:position]))


def _read(stream: BinaryIO, start: int, length: int) -> bytes:
    stream.seek(start)
    return stream.read(length)


def _stream(body: bytes) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(body))


_READERS: dict[int, type[Header] | type[Channel] | type[Attachment] | type[Metadata]] = {
    _HEADER: Header,
    _CHANNEL: Channel,
    _ATTACHMENT: Attachment,
    _METADATA: Metadata,
}
