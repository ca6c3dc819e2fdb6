"""A process that another one takes the place of whenever it ends, until it is stopped for good."""

import asyncio
import logging
import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any

from movingout.server.agent_workers.process_restarts import ProcessRestarts
from movingout.server.processes.channel import Channel

log = logging.getLogger(__name__)

QUICK_DEATH_S = 2.0  # a process that died younger than this is not replaced at once
STOP_S = 15.0


class KeptProcess(ABC):
    """A subclass says what one life of the process is. `begin` and `stop` need a running event loop."""

    _channel: Channel[Any, Any] | None = None  # while the process lives

    def __init__(self, what: str) -> None:
        """`what` it is called in the log."""
        self.pid = 0
        self.restart_record = ProcessRestarts(what)  # a subclass says when the process was `seen`
        self._what = what
        self._stopping = False
        self._task: asyncio.Task[None] | None = None

    @property
    def restarts(self) -> int:
        """How often it was replaced."""
        return self.restart_record.restarts

    def faults(self) -> Iterator[str]:
        """Whether the process does not serve, and will not by itself."""
        return self.restart_record.faults()

    def begin(self) -> None:
        """Start the process, and keep one running until `stop`."""
        self.restart_record.seen()
        self._task = asyncio.create_task(self._keep_alive(), name=self._what)

    async def stop(self) -> None:
        """End the process: it sees its channel closed."""
        self._stopping = True
        if self._channel is not None:
            self._channel.close()
        if self._task is not None:
            try:
                await asyncio.wait_for(self._task, STOP_S)
            except TimeoutError:
                log.error("the process %d of %s did not end in time and was killed", self.pid, self._what)

    @abstractmethod
    async def _one_life(self) -> None:
        """Start a process, keep `pid` and `_channel`, and return when it has ended. Whatever it raises is logged."""

    async def _keep_alive(self) -> None:
        while not self._stopping:
            born = time.monotonic()
            try:
                await self._one_life()
            except Exception as error:  # without files or memory for a moment; whatever it was, the next one may live
                log.error("%s cannot be run: %s", self._what, error, exc_info=not isinstance(error, OSError))
            if self._stopping:
                return
            self.restart_record.ended()
            log.warning("the process %d of %s has ended; starting another", self.pid, self._what)
            if time.monotonic() - born < QUICK_DEATH_S:
                await asyncio.sleep(QUICK_DEATH_S)
