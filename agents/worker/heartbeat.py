"""What a worker is doing now, in a small shared file that can be read while the worker hangs.

A worker in an agent's endless loop could not send a message.
"""

import mmap
import os
import struct
import time
from typing import Literal, NamedTuple

Phase = Literal["idle", "deciding", "loading", "overrun"]  # overrun: it ends, because of an agent
_PHASES: tuple[Phase, ...] = ("idle", "deciding", "loading", "overrun")
_LAYOUT = struct.Struct("<dqq")  # since (monotonic seconds), phase, key of the seat
_NO_SEAT = -1


class Activity(NamedTuple):
    """What the worker does, since when, and for which seat (None: for none)."""

    since: float
    phase: Phase
    key: int | None


class WorkerHeartbeat:
    """The shared file, written by the worker and read by the server."""

    def __init__(self, descriptor: int) -> None:
        if os.fstat(descriptor).st_size < _LAYOUT.size:
            os.ftruncate(descriptor, _LAYOUT.size)
        self._memory = mmap.mmap(descriptor, _LAYOUT.size)

    def write(self, phase: Phase, key: int | None = None) -> None:
        """Note what starts now."""
        stored = _NO_SEAT if key is None else key
        _LAYOUT.pack_into(self._memory, 0, time.monotonic(), _PHASES.index(phase), stored)

    def read(self) -> Activity:
        """What the worker noted last."""
        since, phase, key = _LAYOUT.unpack_from(self._memory, 0)
        return Activity(since, _PHASES[phase], None if key == _NO_SEAT else key)

    def close(self) -> None:
        """Unmap; the file itself belongs to whoever opened it."""
        self._memory.close()
