"""The leases of shards in PostgreSQL: who has which, until when, and since which fencing token.

A lease ends by the clock of the database, which all nodes share. Every statement is one transaction of its own, and
whoever takes a lease names the fencing token that was seen: of two that try, one gets it. A token only grows.
"""

import asyncio
import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from movingout.maps.extras import needs_extra
from movingout.server.cluster.errors import ClusterError, DatabaseAway
from movingout.server.cluster.shards import SHARDS, STUDY
from movingout.server.security.tokens import new_token

LEASE_S = 5.0
FORGET_S = 24 * 3600.0  # by the clock of the database: then nobody waits for whoever had a shard any more
CALL_SHARE = 0.3  # of a lease, for an answer of the database: three calls fit into one
CONNECT_S = 2
SCHEMA = 2
LOCK = 7_306_411  # of PostgreSQL, while the tables are made: any number that nobody else uses
NOW = "clock_timestamp()"

_TABLES = """
CREATE SCHEMA IF NOT EXISTS movingout_cluster;
CREATE TABLE IF NOT EXISTS movingout_cluster.version (number int NOT NULL);
CREATE TABLE IF NOT EXISTS movingout_cluster.node (
  name text PRIMARY KEY, run text NOT NULL, folder text NOT NULL, version text NOT NULL, format text NOT NULL,
  address text NOT NULL, seen timestamptz NOT NULL, rooms int NOT NULL, state text NOT NULL);
CREATE TABLE IF NOT EXISTS movingout_cluster.lease (
  shard text PRIMARY KEY, fence bigint NOT NULL, node text, run text, folder text, format text,
  shared boolean NOT NULL, expires timestamptz NOT NULL, rooms int NOT NULL);
CREATE SCHEMA IF NOT EXISTS movingout_identities;
CREATE TABLE IF NOT EXISTS movingout_cluster.secret (value text NOT NULL);
"""


@dataclass(frozen=True, slots=True)
class NodeIdentity:
    """Who asks: `run` differs for each start of a node, `folder` is the id of its data folder."""

    name: str
    run: str
    folder: str
    version: str
    format: str  # of rooms on the disk and of the protocol: nodes of one format can go on with each other's rooms
    address: str = ""


@dataclass(frozen=True, slots=True)
class NodeRow:
    """A node as the others see it."""

    name: str
    folder: str
    version: str
    format: str
    address: str
    state: str
    rooms: int
    run: str
    alive: bool  # it has told the database so during the last lease


@dataclass(frozen=True, slots=True)
class LeaseRow:
    """A shard: `node` is None while nobody has it; `shared`: whoever has the same folder may take it over."""

    shard: str
    fence: int
    node: str | None
    run: str | None
    folder: str | None
    format: str | None
    shared: bool
    rooms: int
    expired_s: float  # negative while the lease lasts


@dataclass(frozen=True, slots=True)
class ClusterView:
    """What the database says at one moment."""

    leases: tuple[LeaseRow, ...]
    nodes: tuple[NodeRow, ...]

    def lease(self, shard: str) -> LeaseRow | None:
        return next((each for each in self.leases if each.shard == shard), None)

    def node(self, name: str | None) -> NodeRow | None:
        return next((each for each in self.nodes if each.name == name), None)


class LeaseStore:
    """Calls to the database, one at a time. Each raises DatabaseAway; a call that takes too long is given up.

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

    async def prepare(self) -> None:
        """Make the tables where there are none. Raises ClusterError when they are of a newer version."""
        found = await self._call(self._prepare, CONNECT_S + 8.0)
        if found != SCHEMA:
            raise ClusterError(
                f"the tables in {self.shown} are of version {found}, and this program knows version {SCHEMA}: "
                "use the same version of the program on all nodes"
            )

    async def _prepare(self, connection: Any) -> int:
        async with connection.transaction():
            await connection.execute(f"SELECT pg_advisory_xact_lock({LOCK})")
            await connection.execute(_TABLES)
            await connection.execute(
                "INSERT INTO movingout_cluster.version "
                "SELECT %s WHERE NOT EXISTS (SELECT FROM movingout_cluster.version WHERE number >= %s)",
                (SCHEMA, SCHEMA),
            )
            await connection.execute(
                "INSERT INTO movingout_cluster.secret "
                "SELECT %s WHERE NOT EXISTS (SELECT FROM movingout_cluster.secret)",
                (new_token(),),
            )
            await connection.execute(
                "INSERT INTO movingout_cluster.lease (shard, fence, shared, expires, rooms) "
                f"SELECT unnest(%s::text[]), 0, false, {self._now}, 0 ON CONFLICT DO NOTHING",
                ([*SHARDS, STUDY],),
            )
            cursor = await connection.execute("SELECT max(number) FROM movingout_cluster.version")
            (number,) = await cursor.fetchone()
            return int(number)

    async def secret(self) -> str:
        """What nodes sign the calls to each other with."""
        found = await self._call(lambda each: self._rows(each, "SELECT value FROM movingout_cluster.secret", {}))
        return str(found[0][0])

    async def view(self) -> ClusterView:
        view: ClusterView = await self._call(self._view)
        return view

    async def _view(self, connection: Any) -> ClusterView:
        cursor = await connection.execute(
            "SELECT shard, fence, node, run, folder, format, shared, rooms, "
            f"extract(epoch FROM {self._now} - expires)::float FROM movingout_cluster.lease ORDER BY shard"
        )
        leases = tuple(LeaseRow(*row) for row in await cursor.fetchall())
        cursor = await connection.execute(
            "SELECT name, folder, version, format, address, state, rooms, run, "
            f"state <> 'ended' AND seen > {self._now} - make_interval(secs => %s) "
            "FROM movingout_cluster.node ORDER BY name",
            (self.lease_s,),
        )
        return ClusterView(leases, tuple(NodeRow(*row) for row in await cursor.fetchall()))

    async def join(self, who: NodeIdentity) -> bool:
        """Register this run of a node; False while another run of the same name is alive.

        Nodes that were not seen for a day, and have no rooms, are forgotten.
        """
        statement = f"""
            INSERT INTO movingout_cluster.node AS n
              VALUES (%(name)s, %(run)s, %(folder)s, %(version)s, %(format)s, %(address)s, {self._now}, 0, 'serving')
            ON CONFLICT (name) DO UPDATE SET run = excluded.run, folder = excluded.folder, rooms = 0,
              version = excluded.version, format = excluded.format, address = excluded.address, seen = excluded.seen,
              state = excluded.state
            WHERE n.run = excluded.run OR n.state = 'ended'
              OR n.seen < {self._now} - make_interval(secs => %(lease_s)s)
            RETURNING name"""
        if not await self._call(lambda connection: self._rows(connection, statement, self._values(who))):
            return False
        prune = f"""
            DELETE FROM movingout_cluster.node AS n
            WHERE name <> %(name)s AND seen < {self._now} - make_interval(secs => %(forget_s)s)
              AND NOT EXISTS (SELECT FROM movingout_cluster.lease WHERE node = n.name AND rooms > 0)
            RETURNING name"""
        await self._call(lambda connection: self._rows(connection, prune, self._values(who)))
        return True

    async def renew(
        self, who: NodeIdentity, held: Mapping[str, int], rooms: Mapping[str, int], shared: bool, state: str
    ) -> tuple[frozenset[str], ClusterView]:
        """Renew the leases `held` (their fencing tokens, by shard): those that are still this node's, and the view.

        `rooms` are those of each shard; `shared` says whether this node stops when a lease is over, so that another
        one may take it.
        """
        answer: tuple[frozenset[str], ClusterView] = await self._call(
            lambda connection: self._renew(connection, who, held, rooms, shared, state)
        )
        return answer

    async def _renew(
        self,
        connection: Any,
        who: NodeIdentity,
        held: Mapping[str, int],
        rooms: Mapping[str, int],
        shared: bool,
        state: str,
    ) -> tuple[frozenset[str], ClusterView]:
        values = self._values(who) | {
            "shards": list(held),
            "fences": list(held.values()),
            "counts": [rooms.get(shard, 0) for shard in held],
            "shared": shared,
            "state": state,
            "rooms": sum(rooms.values()),
        }
        kept = await self._rows(
            connection,
            f"""UPDATE movingout_cluster.lease AS l SET expires = {self._expiry}, shared = %(shared)s, rooms = h.rooms
                FROM unnest(%(shards)s::text[], %(fences)s::bigint[], %(counts)s::int[]) AS h (shard, fence, rooms)
                WHERE l.shard = h.shard AND l.fence = h.fence AND l.run = %(run)s RETURNING l.shard""",
            values,
        )
        await connection.execute(
            f"""UPDATE movingout_cluster.node SET seen = {self._now}, rooms = %(rooms)s, state = %(state)s
                WHERE name = %(name)s AND run = %(run)s""",
            values,
        )
        return frozenset(row[0] for row in kept), await self._view(connection)

    async def take(self, who: NodeIdentity, seen: LeaseRow, shared: bool) -> int | None:
        """Take a lease that was seen to be over or free; its new fencing token, None when this node may not have it.

        A shard with rooms goes to a node that has the same folder, if its last one stops when the lease is over, and
        otherwise only to the node that had it. The study, which is in a database, goes to any node.
        """
        found = await self._call(
            lambda connection: self._rows(
                connection,
                f"""UPDATE movingout_cluster.lease SET node = %(name)s, run = %(run)s, folder = %(folder)s,
                      format = %(format)s, fence = fence + 1, shared = %(shared)s, expires = {self._expiry}
                    WHERE shard = %(shard)s AND fence = %(fence)s AND expires <= {self._now}
                      AND (node IS NULL OR shard = '{STUDY}'
                        OR expires < {self._now} - make_interval(secs => %(forget_s)s)
                        OR (folder = %(folder)s AND format = %(format)s AND (shared OR node = %(name)s)))
                    RETURNING fence""",
                self._values(who) | {"shard": seen.shard, "fence": seen.fence, "shared": shared},
            )
        )
        return int(found[0][0]) if found else None

    async def release(self, who: NodeIdentity, shard: str, fence: int) -> None:
        """Give a shard without rooms to whoever wants it."""
        await self._call(
            lambda connection: self._rows(
                connection,
                f"""UPDATE movingout_cluster.lease SET node = NULL, run = NULL, folder = NULL, format = NULL,
                      shared = false, rooms = 0, expires = {self._now}
                    WHERE shard = %(shard)s AND fence = %(fence)s AND run = %(run)s RETURNING shard""",
                self._values(who) | {"shard": shard, "fence": fence},
            )
        )

    async def leave(self, who: NodeIdentity) -> None:
        """End the leases of this run now, with the rooms as they are, for whoever may go on with them."""
        await self._call(
            lambda connection: self._rows(
                connection,
                f"""WITH node AS (UPDATE movingout_cluster.node SET state = 'ended' WHERE run = %(run)s)
                    UPDATE movingout_cluster.lease SET expires = {self._now} WHERE run = %(run)s RETURNING shard""",
                self._values(who),
            )
        )

    async def close(self) -> None:
        connection, self._connection = self._connection, None
        if connection is not None:
            with contextlib.suppress(self._driver.Error, OSError):
                await connection.close()

    # ---- calls ----------------------------------------------------------------------------------------------

    @property
    def _expiry(self) -> str:
        return f"{self._now} + make_interval(secs => %(lease_s)s)"

    def _values(self, who: NodeIdentity) -> dict[str, Any]:
        return {
            "name": who.name,
            "run": who.run,
            "folder": who.folder,
            "version": who.version,
            "format": who.format,
            "address": who.address,
            "lease_s": self.lease_s,
            "forget_s": FORGET_S,
        }

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
            done, _ = await asyncio.wait({task}, timeout=within_s or self._call_s)
            if not done:
                self._connection = None
                task.add_done_callback(_forget)
                task.cancel()
                raise DatabaseAway(f"the database {self.shown} does not answer in time")
            try:
                return task.result()
            except (self._driver.Error, OSError) as error:
                await self.close()
                raise DatabaseAway(f"the database {self.shown} does not answer: {_reason(error)}") from error

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


def _forget(task: "asyncio.Task[Any]") -> None:
    if not task.cancelled():
        task.exception()  # nobody waits for it any more


def _reason(error: Exception) -> str:
    """The first line, without what the driver puts before it."""
    text = str(error).strip().splitlines()
    return text[0] if text else type(error).__name__
