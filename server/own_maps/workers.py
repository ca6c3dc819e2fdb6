"""The processes that check, vary and solve maps and make generated ones, at lower priority, so that no tick is late."""

import asyncio
import logging
import time
from collections.abc import Callable
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, Literal

from movingout.maps import MapSpec, is_reserved
from movingout.maps.errors import MovingOutError
from movingout.maps.randomize import Split
from movingout.recordings.process_pool import StoppablePool, process_pool
from movingout.server.connection.fair_queue import FairQueue
from movingout.server.own_maps import solving
from movingout.server.own_maps.folder import Outcome
from movingout.server.persistence.work_process import CLOSE_S, NICE

log = logging.getLogger(__name__)

Kind = Literal["checks", "variants", "solves"]

MOST_WAITING = 120  # of a kind that have not been answered
MOST_OF_ONE = 40  # of these for one address, behind which a class may sit
MOST_SOLVES = 4  # solves that have not been answered, one of which is being played


class Busy(MovingOutError):
    """Too much is being asked at once, or this address already has an answer to come."""


class MapWorkers:
    """A process for each kind of work, started when it is first needed. Use inside an event loop.

    Addresses are given as limits know them, empty for the server itself: they take turns, and nobody waits long for
    what another one asks. `on_work` hears for whom a process has worked on a map that is not shipped, and how long.
    """

    def __init__(self, on_work: Callable[[str, float], None] = lambda address, seconds: None) -> None:
        self._pools: dict[Kind, StoppablePool] = {}
        self._queues = {kind: FairQueue() for kind in ("checks", "variants")}
        self._on_work = on_work
        self._solving: set[str] = set()  # addresses
        self._closed = False

    async def check(self, document: object, address: str) -> solving.Checked:
        """The map of a document, its faults and hints. Raises Busy and solving.TooSlow."""
        checked: solving.Checked = await self._in_turn("checks", address, address, solving.check, document)
        return checked

    async def generate(self, name: str, address: str) -> MapSpec:
        """The generated map of a name. Raises Busy, solving.TooSlow, and MapError for a name of none."""
        spec: MapSpec = await self._in_turn("checks", address, address, solving.generate, name)
        return spec

    async def variant(self, designed: MapSpec, seed: int, split: Split, address: str = "") -> MapSpec:
        """A randomised map. Raises Busy, solving.TooSlow, and MapError where it has none.

        Shipped maps, of which a class plays many at once, are at nobody's expense.
        """
        charged = "" if is_reserved(designed.name) else address
        within_s = solving.VARIANT_S if address else solving.OWN_VARIANT_S
        work = solving.variant, designed, seed, split, within_s
        spec: MapSpec = await self._in_turn("variants", address, charged, *work)
        return spec

    async def read_file(self, path: Path) -> Outcome:
        """The map of a file of the operator's folder, or what is wrong with it."""
        try:
            async with self._queues["checks"].turn():
                outcome: Outcome = await self._run("checks", solving.read_file, path)
        except Busy:
            return f"{path.name} cannot be looked at: the process that reads it ends; change the file to try again"
        return outcome

    async def solve(self, spec: MapSpec, address: str) -> dict[str, Any]:
        """What a scripted pair does on a map; one answer per address at a time. Raises Busy and solving.TooSlow."""
        if address in self._solving:
            raise Busy("A map from your address is being solved already; wait for it.")
        if len(self._solving) >= MOST_SOLVES:
            raise Busy("The server is solving other maps at the moment; try again in a few seconds.")
        self._solving.add(address)
        try:
            solution: dict[str, Any] = await self._run("solves", solving.solve, spec)
        finally:
            self._solving.discard(address)
        return solution

    async def close(self) -> None:
        """End the processes; what is still being worked on after CLOSE_S is broken off."""
        self._closed = True
        pools, self._pools = list(self._pools.values()), {}
        await asyncio.gather(*(asyncio.to_thread(pool.end, CLOSE_S) for pool in pools))

    async def _in_turn(self, kind: Kind, address: str, charged: str, work: Any, *arguments: Any) -> Any:
        """Run when it is the turn of an address, at the expense of `charged`. Raises Busy."""
        if address and not self._queues[kind].has_place(address, MOST_WAITING, MOST_OF_ONE):
            raise Busy("The server is checking many maps at the moment; try again in a few seconds.")
        async with self._queues[kind].turn(address):
            started = time.monotonic()
            seconds: float | None = None
            try:
                seconds, result, error = await self._run(kind, _timed, work, *arguments)
            finally:
                if charged:  # what ends a process is no less work
                    self._on_work(charged, time.monotonic() - started if seconds is None else seconds)
            if error is not None:
                raise error
            return result

    async def _run(self, kind: Kind, work: Any, *arguments: Any) -> Any:
        """Run in the process of a kind; once more in a new one if it died.

        Raises Busy when it dies again, or after `close`.
        """
        for _ in range(2):
            if self._closed:
                break
            if kind not in self._pools:
                self._pools[kind] = process_pool(1, NICE)
            pool = self._pools[kind]
            try:
                return await asyncio.get_running_loop().run_in_executor(pool, work, *arguments)
            except BrokenProcessPool:
                log.error("the process for %s of maps died; another one will be started", kind)
                if self._pools.get(kind) is pool:
                    del self._pools[kind]
        raise Busy("The server cannot look at maps at the moment; try again in a minute.")


def _timed(work: Callable[..., Any], *arguments: Any) -> tuple[float, Any, Exception | None]:
    """How long the work took, without the start of its process, and its result or what it raised."""
    started = time.monotonic()
    try:
        result = work(*arguments)
        return time.monotonic() - started, result, None
    except Exception as error:  # noqa: BLE001 - of any kind: raised again by who asked
        return time.monotonic() - started, None, error
