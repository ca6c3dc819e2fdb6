"""Handshakes and frames of websockets (RFC 6455, 4.2 and 5.2): which are whole, and one of the server as bytes."""

import struct
from collections.abc import Iterable

FINAL_TEXT = 0x81
FINAL_BINARY = 0x82
MASKED = 0x80
LONG = 126  # from here on the length field says that the real one follows, in two (126) or in eight bytes (127)
_LONG_HEAD = struct.Struct(">BBH")
LONGEST = 0xFFFF  # that it can say
NEGOTIATED = ("connection", "upgrade", "sec-websocket-")  # how the headers begin that make a handshake


def is_ascii_handshake(headers: Iterable[tuple[str, str]]) -> bool:
    """Whether what makes a handshake is ASCII, as it has to be; cookies and headers of proxies need not be."""
    return all(value.isascii() for name, value in headers if name.lower().startswith(NEGOTIATED))


def is_utf8(data: bytes) -> bool:
    try:
        data.decode()
    except UnicodeDecodeError:
        return False
    return True


def frame_of(message: str | bytes) -> bytes | None:
    """A text or binary frame of the server; None where the message is too long for one like this."""
    kind, payload = (FINAL_TEXT, message.encode()) if isinstance(message, str) else (FINAL_BINARY, message)
    size = len(payload)
    if size > LONGEST:
        return None
    return (bytes((kind, size)) if size < LONG else _LONG_HEAD.pack(kind, LONG, size)) + payload


def begins_small_binary(data: bytes, at: int) -> bool:
    """Whether a small binary frame of a client begins at `at`, of which the length field is there."""
    return data[at] == FINAL_BINARY and MASKED <= data[at + 1] < MASKED + LONG


def is_small_binary(data: bytes) -> bool:
    """Whether this is one whole small binary frame of a client: what nearly all data of a game is."""
    return len(data) > 6 and data[0] == FINAL_BINARY and data[1] == MASKED + len(data) - 6 and data[1] < MASKED + LONG


def frame_end(buffer: bytes, at: int, most: int) -> int:
    """Where the frame that begins at `at` ends; 0 when it is not whole yet.

    A frame that announces more than `most` bytes ends with its head: Uvicorn refuses it when it sees that.
    """
    if len(buffer) - at < 2:
        return 0
    length, head = buffer[at + 1] & 127, 2
    if length >= LONG:
        head = 4 if length == LONG else 10
        if len(buffer) - at < head:
            return 0
        length = int.from_bytes(buffer[at + 2 : at + head], "big")
    head += 4 if buffer[at + 1] & MASKED else 0
    end = at + head + (0 if length > most else length)
    return end if end <= len(buffer) else 0
