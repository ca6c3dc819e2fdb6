"""A database whose time moves only when a test says so."""

import asyncio

import psycopg

from movingout.server.cluster.lease_store import LeaseStore, NodeIdentity
from movingout.server.cluster.limit_store import LimitStore

SQL = "(SELECT at FROM test_clock)"


class TestClock:
    """Time in seconds, for the nodes and for the database at once."""

    __test__ = False

    def __init__(self, url: str) -> None:
        self.url, self.now = url, 0.0
        self._connection = psycopg.connect(url, autocommit=True)
        self._connection.execute("CREATE TABLE IF NOT EXISTS test_clock (at timestamptz)")
        self._connection.execute("TRUNCATE test_clock")
        self._connection.execute("INSERT INTO test_clock VALUES ('2026-01-01')")

    def __call__(self) -> float:
        return self.now

    def advance(self, seconds: float) -> None:
        self.now += seconds
        self._connection.execute("UPDATE test_clock SET at = at + make_interval(secs => %s)", (seconds,))

    async def sleep(self, seconds: float) -> None:
        """Time passes at once."""
        self.advance(seconds)
        await asyncio.sleep(0)

    def forget_leases(self) -> None:
        """As after the tables were made."""
        self._connection.execute(
            "UPDATE movingout_cluster.lease SET node = NULL, run = NULL, folder = NULL, fence = 0, shared = false, "
            f"rooms = 0, expires = {SQL}"
        )

    def store(self) -> LeaseStore:
        return LeaseStore(self.url, now=SQL, call_s=20.0)

    def limits(self) -> LimitStore:
        return LimitStore(self.url, now=SQL, call_s=20.0)

    def close(self) -> None:
        self._connection.close()


def identity(name: str, run: str = "", folder: str = "shared", **fields: str) -> NodeIdentity:
    described = {"version": "1.0", "format": "1", **fields}
    return NodeIdentity(name=name, run=run or f"run of {name}", folder=folder, **described)
