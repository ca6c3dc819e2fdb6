"""Calls to the PostgreSQL database of a cluster: one at a time, over one connection, and none waits for long."""

import asyncio
import contextlib
from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import Any

from movingout.maps.extras import needs_extra
from movingout.server.cluster.errors import ClusterError, DatabaseAway
from movingout.server.settings import LEASE_S

CALL_SHARE = 0.3  # of a lease, for an answer of the database: three calls fit into one
CONNECT_S = 2
NOW = "clock_timestamp()"


class ClusterDatabase:
    """A call that takes too long is given up. Raises ClusterError for what is no address of PostgreSQL.

    `now` is SQL for the time of the database, which tests replace.
    """

    def __init__(self, url: str, now: str = NOW, lease_s: float = LEASE_S, call_s: float = 0.0) -> None:
        with needs_extra("postgres", "a cluster"):
            import psycopg
        from movingout.study.store.database import shown  # SQLAlchemy, which that extra brings

        try:
            self.shown = shown(url)
        except Exception as error:  # SQLAlchemy's own, of several kinds
            raise ClusterError(_NO_URL.format(url=url)) from error
        if not url.startswith(("postgresql://", "postgres://")):
            raise ClusterError(_NO_URL.format(url=self.shown))
        self._driver = psycopg
        self.lease_s = lease_s
        self._url, self._now, self._call_s = url, now, call_s or CALL_SHARE * lease_s
        self._connection: Any = None
        self._one_at_a_time = asyncio.Lock()

    async def secret(self) -> str:
        """What nodes sign the calls to each other with."""
        found = await self._call(lambda each: self._rows(each, "SELECT value FROM movingout_cluster.secret", {}))
        return str(found[0][0])

    async def cluster(self) -> str:
        """A name for the cluster: another one in each database, also in a copy of one."""
        statement = """SELECT value, (SELECT oid::text FROM pg_database WHERE datname = current_database())
            FROM movingout_cluster.secret"""
        found = await self._call(lambda each: self._rows(each, statement, {}))
        return sha256("|".join(found[0]).encode()).hexdigest()

    async def close(self) -> None:
        connection, self._connection = self._connection, None
        if connection is not None:
            with contextlib.suppress(self._driver.Error, OSError):
                await connection.close()

    async def _rows(self, connection: Any, statement: str, values: Mapping[str, Any]) -> Sequence[Any]:
        cursor = await connection.execute(statement, values)
        rows: Sequence[Any] = await cursor.fetchall()
        return rows

    async def _call(self, work: Any, within_s: float = 0.0) -> Any:
        """What `work(connection)` returns. Raises DatabaseAway.

        A call that takes too long is left to itself and its connection given up: to wait for its end, as cancelling
        does, would last as long as the database is away.
        """
        async with self._one_at_a_time:
            task = asyncio.create_task(self._work(work))
            if not await self._ends_in_time(task, within_s or self._call_s):
                raise DatabaseAway(f"the database {self.shown} does not answer in time")
            try:
                return task.result()
            except (self._driver.Error, OSError) as error:
                await self.close()
                raise DatabaseAway(f"the database {self.shown} does not answer: {_reason(error)}") from error

    async def _ends_in_time(self, task: "asyncio.Task[Any]", within_s: float) -> bool:
        """Whether a call has ended; otherwise it is given up.

        Whoever is cancelled meanwhile waits all the same: the next call could overtake the rest of this one, so that
        a node that leaves would be told to be serving still.
        """
        try:
            await asyncio.wait({task}, timeout=within_s)
        except asyncio.CancelledError:
            task.add_done_callback(lambda task: _forget(task, None))
            await asyncio.wait({task}, timeout=within_s)
            raise
        finally:
            if not task.done():
                given_up, self._connection = self._connection, None
                task.add_done_callback(lambda task: _forget(task, given_up))
                task.cancel()
        return task.done()

    async def _work(self, work: Any) -> Any:
        if self._connection is None or self._connection.closed:
            self._connection = await self._driver.AsyncConnection.connect(
                self._url,
                autocommit=True,
                connect_timeout=CONNECT_S,
                application_name="movingout cluster",
                options=f"-c statement_timeout={round(self._call_s * 1e3)}",
                tcp_user_timeout=3000,
            )
        return await work(self._connection)


_NO_URL = "{url!r} is not the address of a PostgreSQL database; it looks like postgresql://user@host/name"


def _forget(task: "asyncio.Task[Any]", connection: Any) -> None:
    """Nobody waits for a call any more, nor uses its connection."""
    if not task.cancelled():
        task.exception()
    if connection is not None:
        connection.pgconn.finish()


def _reason(error: Exception) -> str:
    """The first line, without what the driver puts before it."""
    text = str(error).strip().splitlines()
    return text[0] if text else type(error).__name__
