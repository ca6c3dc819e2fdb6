"""One other process for slow work: started when it is needed, and started again when it dies."""

import asyncio
import logging
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from movingout.recordings import RecordingError
from movingout.recordings.process_pool import process_pool
from movingout.server.connection.fair_queue import FairQueue

log = logging.getLogger(__name__)

NICE = 10  # ticks come first
MOST_WAITING = 80  # calls; more are refused, so that nobody waits for minutes
MOST_OF_ONE = 30  # of these for one address, behind which a class may sit
CLOSE_S = 3.0  # for what runs when it is closed


class ReadersBusy(RecordingError):
    """Too much waits already; a minute later it can be asked again."""


class WorkProcess:
    """Runs functions one after another. Use inside a running event loop."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._executor = process_pool(1, NICE)
        self._queue = FairQueue()  # a process that dies concerns one call, not all that wait for it
        self._closed = False

    async def run(self, work: Any, *arguments: Any, urgent: bool = False, address: str = "") -> Any:
        """The result of `work(*arguments)`; both must be picklable. Whatever it raises is raised here.

        Addresses, as limits know them, take turns: nobody waits long for what another one asks.
        Once more in a new process if it died. RecordingError when it dies again, or after `close`; ReadersBusy, unless
        it is `urgent`, when too many are waiting.
        """
        if not urgent and not self._queue.has_place(address, MOST_WAITING, MOST_OF_ONE):
            raise ReadersBusy("too many recordings are being read at the moment; try again in a minute")
        async with self._queue.turn(address):
            return await self._attempt_twice(work, arguments)

    async def close(self) -> None:
        """Wait CLOSE_S for what runs, not for what waits, and end the process."""
        self._closed = True
        await asyncio.to_thread(self._executor.end, CLOSE_S)

    async def _attempt_twice(self, work: Any, arguments: tuple[Any, ...]) -> Any:
        for _ in range(2):
            if self._closed:
                raise RecordingError(f"the process for {self._what} is being stopped")
            try:
                return await asyncio.get_running_loop().run_in_executor(self._executor, work, *arguments)
            except BrokenProcessPool:
                log.error("the process for %s died; another one will be started", self._what)
                self._executor.shutdown(wait=False)
                self._executor = process_pool(1, NICE)
        raise RecordingError(f"the process for {self._what} died twice; is there enough memory?")
