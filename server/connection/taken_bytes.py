"""How much of what was sent has been taken at the other end: a slow reader is told from one that takes nothing."""

import asyncio
import socket
import struct

_BYTES_ACKED = struct.Struct("120xQ")  # in Linux's struct tcp_info, since 4.1


def taken_bytes(transport: asyncio.Transport) -> int:
    """A number that grows with each byte that is taken; only its differences mean something.

    Over TLS what waits in the transport does not tell: up to half a megabyte is encrypted, and handed on, at once.
    """
    if hasattr(socket, "TCP_INFO") and (connection := transport.get_extra_info("socket")) is not None:
        try:
            info = connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _BYTES_ACKED.size)
        except OSError:
            info = b""
        if len(info) == _BYTES_ACKED.size:
            return int(_BYTES_ACKED.unpack(info)[0])
    return -transport.get_write_buffer_size()
