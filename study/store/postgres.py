"""PostgreSQL: how it is reached, and for how long anybody waits for it.

A machine that is gone answers nothing, not even that it is gone. Whoever connects waits CONNECT_S, and what was sent
must have arrived within SILENT_S. A database that holds its connections and says nothing is noticed by the caller
alone, who then cuts them (`Connections.hang_up`).
"""

import contextlib
import os
import socket
import time
from typing import Any
from weakref import WeakSet

from sqlalchemy import Engine, create_engine, event, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, InterfaceError, OperationalError

from movingout.maps.extras import needs_extra
from movingout.study.errors import StoreError

CONNECT_S = 3
SILENT_S = 3
PATIENCE = {
    "connect_timeout": CONNECT_S,
    "tcp_user_timeout": 1000 * SILENT_S,
    "keepalives_idle": 10,
    "keepalives_interval": 3,
    "keepalives_count": 3,
}
_GAVE_UP = ("57014", "55P03", "57P01", "57P02", "57P03", "53300")
"""SQLSTATE of time-outs of a statement and of a lock, of a database that ends or starts, of too many connections."""


def postgres_engine(url: str) -> Engine:
    """Raises StoreError for an address of something else. What the address itself says of time-outs holds."""
    try:
        parsed = make_url(url)
    except ArgumentError:
        raise StoreError(
            f"{url!r} is not the address of a database; it should look like postgresql://user@host/name"
        ) from None
    if parsed.get_backend_name() != "postgresql":
        raise StoreError(
            f"{parsed.get_backend_name()} is not supported; give a postgresql:// address, or none for SQLite"
        )
    patience = {name: value for name, value in PATIENCE.items() if name not in parsed.query}
    with needs_extra("postgres", "PostgreSQL"):
        return create_engine(parsed.set(drivername="postgresql+psycopg"), pool_pre_ping=True, connect_args=patience)


class Connections:
    """The open connections of an engine, and when one of them last said something."""

    def __init__(self, engine: Engine) -> None:
        self.heard_at = time.monotonic()
        self._open: WeakSet[Any] = WeakSet()
        event.listen(engine, "connect", self._opened)
        event.listen(engine, "before_cursor_execute", self._heard)
        event.listen(engine, "after_cursor_execute", self._heard)

    def hang_up(self) -> None:
        """Cut them, from another thread than the one that waits for an answer: it gets an error instead."""
        for connection in list(self._open):
            with contextlib.suppress(Exception), _socket_of(connection) as cut:  # it may be closed in the same moment
                cut.shutdown(socket.SHUT_RDWR)

    def _opened(self, connection: Any, record: Any) -> None:
        self._open.add(connection)
        self._heard()

    def _heard(self, *_: Any) -> None:
        self.heard_at = time.monotonic()


def _socket_of(connection: Any) -> socket.socket:
    """Its socket by another number, which can be closed."""
    return socket.socket(fileno=os.dup(connection.fileno()))


def gave_up(error: DBAPIError) -> bool:
    """Whether PostgreSQL was waited for in vain, so that another attempt may succeed."""
    state = getattr(error.orig, "sqlstate", "")  # None: there was no answer
    return state in _GAVE_UP or (state is None and isinstance(error, OperationalError | InterfaceError))
