"""How much of what was sent has been taken at the other end: a slow reader is told from one that takes nothing."""

import asyncio
import socket
import struct

_BYTES_ACKED = struct.Struct("120xQ")  # in Linux's struct tcp_info, since 4.1


def taken_bytes(transport: asyncio.Transport) -> int:
    """A number that grows with each byte that is taken; only its differences mean something.

    Over TLS what waits in the transport does not tell: up to half a megabyte is encrypted, and handed on, at once.
    Where the system does not count, it is all there is, and what is written next hides what was taken.
    """
    counted = _counted(transport)
    return -transport.get_write_buffer_size() if counted is None else counted


def counts_taken_bytes(transport: asyncio.Transport) -> bool:
    """Whether the system counts them: Linux does."""
    return _counted(transport) is not None


def _counted(transport: asyncio.Transport) -> int | None:
    if hasattr(socket, "TCP_INFO") and (connection := transport.get_extra_info("socket")) is not None:
        try:
            info = connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _BYTES_ACKED.size)
        except OSError:
            info = b""
        if len(info) == _BYTES_ACKED.size:
            return int(_BYTES_ACKED.unpack(info)[0])
    return None
