"""Pairs of sockets that keep the boundaries of messages, over which processes hand connections to each other."""

import contextlib
import socket


def message_sockets() -> tuple[socket.socket, socket.socket]:
    """Two connected ends. Raises OSError where the system has none, as macOS."""
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)


def has_message_sockets() -> bool:
    """Whether the system has such pairs, without which a server is one process."""
    with contextlib.suppress(OSError):
        for end in message_sockets():
            end.close()
        return True
    return False
