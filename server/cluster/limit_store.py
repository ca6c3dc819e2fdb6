"""What addresses have used of their limits at all nodes, in PostgreSQL.

A rate is a token bucket, kept as the time at which it is full again: a row that lies in the past says nothing any more.
Rooms are counted per run of a node, and count while the node is alive. All times are those of the database.
"""

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from movingout.server.cluster.database import ClusterDatabase
from movingout.server.connection.other_nodes import RoomCount

OPENING, RECORDED = "opening", "recorded"


class Rate(NamedTuple):
    """A bucket of `burst` that is filled with `per_s`."""

    per_s: float
    burst: float

    def seconds(self, cost: float) -> float:
        """How long it takes to fill in so much."""
        return cost / self.per_s


class LimitStore(ClusterDatabase):
    """Addresses are words that say nothing (`SharedLimits` makes them). Each call raises DatabaseAway."""

    async def take(self, kind: str, address: str, rate: Rate) -> bool:
        """Take one from a bucket; False when it is empty."""
        taken: bool = await self._call(lambda connection: self._take(connection, kind, address, rate))
        return taken

    async def _take(self, connection: Any, kind: str, address: str, rate: Rate) -> bool:
        filled = f"GREATEST(r.full_at, {self._now}) + make_interval(secs => %(cost_s)s)"
        statement = f"""
            INSERT INTO movingout_cluster.address_rate AS r
              VALUES (%(kind)s, %(address)s, {self._now} + make_interval(secs => %(cost_s)s))
            ON CONFLICT (kind, address) DO UPDATE SET full_at = {filled}
            WHERE {filled} <= {self._now} + make_interval(secs => %(burst_s)s)
            RETURNING kind"""
        values = {"kind": kind, "address": address, "cost_s": rate.seconds(1.0), "burst_s": rate.seconds(rate.burst)}
        return bool(await self._rows(connection, statement, values))

    async def has(self, kind: str, address: str, rate: Rate, cost: float) -> bool:
        """Whether a bucket holds so much."""
        statement = f"""
            SELECT FROM movingout_cluster.address_rate WHERE kind = %(kind)s AND address = %(address)s
              AND full_at > {self._now} + make_interval(secs => %(left_s)s)"""
        values = {"kind": kind, "address": address, "left_s": rate.seconds(rate.burst - cost)}
        return not await self._call(lambda connection: self._rows(connection, statement, values))

    async def open_room(self, run: str, address: str, here: RoomCount, rate: Rate) -> RoomCount | None:
        """Count one more opening, and say how many rooms the address has `here`, that one included.

        Returns how many it has at other nodes, None when it has opened too many of late. Of two nodes that ask at
        once, one sees what the other has said: the second waits for the row of the first.
        """
        found: RoomCount | None = await self._call(
            lambda connection: self._open_room(connection, run, address, here, rate)
        )
        return found

    async def _open_room(
        self, connection: Any, run: str, address: str, here: RoomCount, rate: Rate
    ) -> RoomCount | None:
        async with connection.transaction():
            if not await self._take(connection, OPENING, address, rate):
                return None
            await self._say(connection, run, {address: here})
            statement = f"""
                SELECT coalesce(sum(open), 0)::int, coalesce(sum(unjoined), 0)::int
                FROM movingout_cluster.address_rooms AS r JOIN movingout_cluster.node AS n ON n.run = r.run
                WHERE r.address = %(address)s AND r.run <> %(run)s
                  AND n.state <> 'ended' AND n.seen > {self._now} - make_interval(secs => %(lease_s)s)"""
            values = {"address": address, "run": run, "lease_s": self.lease_s}
            return RoomCount(*(await self._rows(connection, statement, values))[0])

    async def publish(self, run: str, rooms: Mapping[str, RoomCount], recorded: Mapping[str, int], rate: Rate) -> None:
        """Say how many rooms addresses have here now, and take from their buckets of bytes what was recorded."""
        await self._call(lambda connection: self._publish(connection, run, rooms, recorded, rate))

    async def _publish(
        self, connection: Any, run: str, rooms: Mapping[str, RoomCount], recorded: Mapping[str, int], rate: Rate
    ) -> None:
        async with connection.transaction():
            await self._say(connection, run, rooms)
            addresses = sorted(recorded)  # two nodes lock rows in the same order
            await connection.execute(
                f"""INSERT INTO movingout_cluster.address_rate AS r
                      SELECT %(kind)s::text, address, {self._now} + make_interval(secs => LEAST(cost_s, %(burst_s)s))
                      FROM unnest(%(addresses)s::text[], %(costs_s)s::float[]) AS u (address, cost_s)
                    ON CONFLICT (kind, address) DO UPDATE SET full_at = LEAST(
                      GREATEST(r.full_at, {self._now}) + (excluded.full_at - {self._now}),
                      {self._now} + make_interval(secs => %(burst_s)s))""",
                {
                    "kind": RECORDED,
                    "addresses": addresses,
                    "costs_s": [rate.seconds(recorded[address]) for address in addresses],
                    "burst_s": rate.seconds(rate.burst),
                },
            )

    async def _say(self, connection: Any, run: str, rooms: Mapping[str, RoomCount]) -> None:
        await self._forget(connection, run, [address for address, count in rooms.items() if not count.open])
        kept = {address: count for address, count in rooms.items() if count.open}
        await connection.execute(
            """INSERT INTO movingout_cluster.address_rooms
                 SELECT address, %(run)s::text, open, unjoined
                 FROM unnest(%(addresses)s::text[], %(open)s::int[], %(unjoined)s::int[]) AS u (address, open, unjoined)
               ON CONFLICT (address, run) DO UPDATE SET open = excluded.open, unjoined = excluded.unjoined""",
            {
                "run": run,
                "addresses": list(kept),
                "open": [count.open for count in kept.values()],
                "unjoined": [count.unjoined for count in kept.values()],
            },
        )

    async def _forget(self, connection: Any, run: str, addresses: Collection[str]) -> None:
        await connection.execute(
            "DELETE FROM movingout_cluster.address_rooms WHERE run = %s AND address = ANY(%s)", (run, list(addresses))
        )

    async def prune(self) -> None:
        """Delete what counts no more: full buckets, and rooms of runs that have ended."""
        await self._call(self._prune)

    async def _prune(self, connection: Any) -> None:
        await connection.execute(
            f"""DELETE FROM movingout_cluster.address_rate WHERE (kind, address) IN (
                  SELECT kind, address FROM movingout_cluster.address_rate WHERE full_at < {self._now}
                  FOR UPDATE SKIP LOCKED)"""
        )
        await connection.execute(
            """DELETE FROM movingout_cluster.address_rooms AS r
               WHERE NOT EXISTS (SELECT FROM movingout_cluster.node WHERE run = r.run AND state <> 'ended')"""
        )
