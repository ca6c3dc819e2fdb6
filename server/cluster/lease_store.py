"""The leases of shards in PostgreSQL: who has which, until when, and since which fencing token.

A lease ends by the clock of the database, which all nodes share. Every statement is one transaction of its own, and
whoever takes a lease names the fencing token that was seen: of two that try, one gets it. A token only grows.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from movingout.server.cluster.database import CONNECT_S, ClusterDatabase
from movingout.server.cluster.errors import ClusterError
from movingout.server.cluster.shards import SHARDS, STUDY
from movingout.server.security.tokens import new_token

FORGET_S = 24 * 3600.0  # by the clock of the database: then nobody waits for whoever had a shard any more
OPENING = "the study is being opened"  # the problem of a node that has just taken it
SCHEMA = 2
LOCK = 7_306_411  # of PostgreSQL, while the tables are made: any number that nobody else uses

_TABLES = """
CREATE SCHEMA IF NOT EXISTS movingout_cluster;
CREATE TABLE IF NOT EXISTS movingout_cluster.version (number int NOT NULL);
CREATE TABLE IF NOT EXISTS movingout_cluster.node (
  name text PRIMARY KEY, run text NOT NULL, folder text NOT NULL, version text NOT NULL, format text NOT NULL,
  address text NOT NULL, seen timestamptz NOT NULL, rooms int NOT NULL, state text NOT NULL);
ALTER TABLE movingout_cluster.node ADD COLUMN IF NOT EXISTS problem text NOT NULL DEFAULT '';
CREATE TABLE IF NOT EXISTS movingout_cluster.lease (
  shard text PRIMARY KEY, fence bigint NOT NULL, node text, run text, folder text, format text,
  shared boolean NOT NULL, expires timestamptz NOT NULL, rooms int NOT NULL);
CREATE SCHEMA IF NOT EXISTS movingout_identities;
CREATE TABLE IF NOT EXISTS movingout_cluster.secret (value text NOT NULL);
CREATE TABLE IF NOT EXISTS movingout_cluster.address_rate (
  kind text, address text, full_at timestamptz NOT NULL, PRIMARY KEY (kind, address));
CREATE TABLE IF NOT EXISTS movingout_cluster.address_rooms (
  address text, run text, open int NOT NULL, unjoined int NOT NULL, PRIMARY KEY (address, run));
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
    problem: str = ""  # why it has the lease of the study, or had it, and does not serve it
    seen_s: float = 0.0  # ago


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


class LeaseStore(ClusterDatabase):
    """Each call raises DatabaseAway."""

    async def refuse_without_nodes(self) -> None:
        """Raise ClusterError where no node has ever been started. For whoever only looks: no tables are made."""
        tables = "SELECT to_regclass('movingout_cluster.lease') IS NOT NULL"
        [[are_there]] = await self._call(lambda connection: self._rows(connection, tables, {}), CONNECT_S + 8.0)
        if not are_there:
            raise ClusterError(f"no node was ever started with the database {self.shown}; check its address")

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
            f"state <> 'ended' AND seen > {self._now} - make_interval(secs => %s), "
            "coalesce(to_jsonb(n) ->> 'problem', ''), "  # tables of nodes of before have no such column
            f"extract(epoch FROM {self._now} - seen)::float FROM movingout_cluster.node AS n ORDER BY name",
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
              state = excluded.state, problem = excluded.problem
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
        self, who: NodeIdentity, held: Mapping[str, int], rooms: Mapping[str, int], shared: bool, state: str,
        problem: str = "",
    ) -> tuple[frozenset[str], ClusterView]:  # fmt: skip
        """Renew the leases `held` (their fencing tokens, by shard): those that are still this node's, and the view.

        `rooms` are those of each shard; `shared` says whether this node stops when a lease is over, so that another
        one may take it.
        """
        answer: tuple[frozenset[str], ClusterView] = await self._call(
            lambda connection: self._renew(connection, who, held, rooms, shared, state, problem)
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
        problem: str,
    ) -> tuple[frozenset[str], ClusterView]:
        values = self._values(who) | {
            "shards": list(held),
            "fences": list(held.values()),
            "counts": [rooms.get(shard, 0) for shard in held],
            "shared": shared,
            "state": state,
            "problem": problem,
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
            f"""UPDATE movingout_cluster.node SET seen = {self._now}, rooms = %(rooms)s, state = %(state)s,
                  problem = %(problem)s
                WHERE name = %(name)s AND run = %(run)s""",
            values,
        )
        return frozenset(row[0] for row in kept), await self._view(connection)

    async def take(self, who: NodeIdentity, seen: LeaseRow, shared: bool) -> int | None:
        """Take a lease that was seen to be over or free; its new fencing token, None when this node may not have it.

        A shard with rooms goes to a node that has the same folder, if its last one stops when the lease is over, and
        otherwise only to the node that had it. The study, which is in a database, goes to any node, and is not served
        before that node says so when it renews.
        """
        found = await self._call(
            lambda connection: self._rows(
                connection,
                f"""WITH taken AS (
                      UPDATE movingout_cluster.lease SET node = %(name)s, run = %(run)s, folder = %(folder)s,
                        format = %(format)s, fence = fence + 1, shared = %(shared)s, expires = {self._expiry}
                      WHERE shard = %(shard)s AND fence = %(fence)s AND expires <= {self._now}
                        AND (node IS NULL OR shard = '{STUDY}'
                          OR expires < {self._now} - make_interval(secs => %(forget_s)s)
                          OR (folder = %(folder)s AND format = %(format)s AND (shared OR node = %(name)s)))
                      RETURNING shard, fence),
                    told AS (UPDATE movingout_cluster.node SET problem = %(opening)s
                      WHERE run = %(run)s AND '{STUDY}' IN (SELECT shard FROM taken))
                    SELECT fence FROM taken""",
                self._values(who) | {"shard": seen.shard, "fence": seen.fence, "shared": shared, "opening": OPENING},
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
