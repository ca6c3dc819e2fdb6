"""The processes that check and solve drawn maps and make generated ones, at lower priority, so that no tick is late."""

import asyncio
import logging
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from movingout.maps import MapSpec
from movingout.maps.errors import MovingOutError
from movingout.recordings.process_pool import process_pool
from movingout.server.own_maps import solving
from movingout.server.own_maps.folder import Outcome

log = logging.getLogger(__name__)

NICE = 10  # ticks come first
MOST_WAITING = 24  # checks that have not been answered
MOST_SOLVES = 4  # solves that have not been answered, one of which is being played


class Busy(MovingOutError):
    """Too much is being asked at once, or this address already has an answer to come."""


class MapWorkers:
    """One process for checks and one for solves, each started when it is first needed. Use inside an event loop."""

    def __init__(self) -> None:
        self._pools: dict[str, ProcessPoolExecutor] = {}
        self._waiting = 0
        self._solving: set[str] = set()  # addresses

    async def check(self, document: object) -> solving.Checked:
        """The map of a document, its faults and hints. Raises Busy and solving.TooSlow."""
        if self._waiting >= MOST_WAITING:
            raise Busy("The server is checking many maps at the moment; try again in a few seconds.")
        self._waiting += 1
        try:
            checked: solving.Checked = await self._run("checks", solving.check, document)
        finally:
            self._waiting -= 1
        return checked

    async def generate(self, name: str) -> MapSpec:
        """The generated map of a name. Raises Busy, solving.TooSlow, and MapError for a name of none."""
        if self._waiting >= MOST_WAITING:
            raise Busy("The server is checking many maps at the moment; try again in a few seconds.")
        self._waiting += 1
        try:
            spec: MapSpec = await self._run("checks", solving.generate, name)
        finally:
            self._waiting -= 1
        return spec

    async def read_file(self, path: Path) -> Outcome:
        """The map of a file of the operator's folder, or what is wrong with it."""
        try:
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
        """End the processes; what is still being worked on ends by its own time limit."""
        pools, self._pools = list(self._pools.values()), {}
        for pool in pools:
            await asyncio.to_thread(pool.shutdown, cancel_futures=True)

    async def _run(self, kind: str, work: Any, *arguments: Any) -> Any:
        """Run in the process of a kind; once more in a new one if it died. Raises Busy when it dies again."""
        for _ in range(2):
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
