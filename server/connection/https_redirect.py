"""What comes to a server with TLS in plain HTTP: an address that was typed without https:// leads to the same page."""

import asyncio
import contextlib
import re
import socket

from movingout.server.connection.hosts import host_allowed
from movingout.server.settings import Settings

MOST_PEEKED = 8192  # bytes
TLS_HANDSHAKE = b"\x16"  # the first byte of its records
_REQUEST = re.compile(rb"(?:GET|HEAD) (/[!-~]*) HTTP/1\.[01]\r\n")
_HOST = re.compile(rb"\r\nhost:[ \t]*([!-~]+)[ \t]*(?=\r\n)", re.IGNORECASE)


async def sent_to_https(connection: socket.socket, settings: Settings, within_s: float) -> bool:
    """Wait for the first bytes, which stay to be read; whether they were a request in plain HTTP and were answered.

    Raises OSError, also when nothing comes in time, or the other end hangs up.
    """
    await _readable(connection, within_s)
    start = connection.recv(MOST_PEEKED, socket.MSG_PEEK)
    if not start:
        raise ConnectionAbortedError("it has hung up")
    address = b"" if start.startswith(TLS_HANDSHAKE) else _asked_for(start, settings)
    if not address:
        return False
    connection.recv(MOST_PEEKED)  # what is left unread would break off the answer
    head = b"HTTP/1.1 307 Temporary Redirect\r\nlocation: https://" + address
    await asyncio.get_running_loop().sock_sendall(
        connection, head + b"\r\ncontent-length: 0\r\nconnection: close\r\n\r\n"
    )
    with contextlib.suppress(OSError):
        connection.shutdown(socket.SHUT_WR)
    return True


def _asked_for(request: bytes, settings: Settings) -> bytes:
    """Host and path of a page of this server that a request in plain HTTP asks for; empty if it is none."""
    page, hosts = _REQUEST.match(request), _HOST.findall(request)
    if page is None or len(hosts) != 1 or not host_allowed([(b"host", hosts[0])], settings):
        return b""
    return bytes(hosts[0] + page[1])


async def _readable(connection: socket.socket, within_s: float) -> None:
    """Wait until something has come, or the other end has hung up. Raises TimeoutError."""
    loop = asyncio.get_running_loop()
    came = asyncio.Event()
    loop.add_reader(connection, came.set)
    try:
        async with asyncio.timeout(within_s):
            await came.wait()
    finally:
        loop.remove_reader(connection)
