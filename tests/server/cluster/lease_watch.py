"""When a lease changed hands, by the clock of the database, which no busy machine makes late."""

import threading
from types import TracebackType

import psycopg
from psycopg.rows import TupleRow

LOOK_S = 0.1
ANSWERS_S = 60  # a database that a test stopped and a failure left stopped never answers
ASKED = """SELECT extract(epoch FROM clock_timestamp())::float, extract(epoch FROM expires)::float, node
FROM movingout_cluster.lease WHERE shard = %s"""


class LeaseWatch:
    """Looks at the lease of a shard until another node than `owner` has it."""

    def __init__(self, database: str, shard: str, owner: str) -> None:
        self._database, self._shard, self._owner = database, shard, owner
        self._expires = self._taken = 0.0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> "LeaseWatch":
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        self._over.set()
        self._thread.join(ANSWERS_S)

    @property
    def after_s(self) -> float:
        """How long after the last end of the owner's lease another node took it: negative if it was given back."""
        assert self._taken, "nobody took it"
        return self._taken - self._expires

    def _watch(self) -> None:
        with psycopg.connect(self._database, autocommit=True, connect_timeout=ANSWERS_S) as connection:
            over = False
            while not over and not self._taken:
                over = self._over.wait(LOOK_S)  # and look once more: whoever came back may have done so a moment ago
                self._look(connection)

    def _look(self, connection: psycopg.Connection[TupleRow]) -> None:
        row = connection.execute(ASKED, (self._shard,)).fetchone()
        assert row is not None
        now, expires, node = row
        if node == self._owner:
            self._expires = max(self._expires, expires)  # giving back sets it to now
        elif node is not None:
            self._taken = now
