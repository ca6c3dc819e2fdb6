"""A worker process of `local_workers`: jobs on stdin, results on stdout, as JSON lines.

It is a program of its own rather than a fork of the caller, so that it works from a notebook and from a script without
a main guard, and so that a crash is no more than a closed pipe to the caller. What agents print goes to stderr; what
they read from stdin has ended.
"""

import json
import os
import queue
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TextIO

from movingout.maps.errors import MovingOutError
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.match import match_from_json


def main() -> None:
    """Play jobs until standard input ends."""
    output = WorkerOutput(os.fdopen(os.dup(1), "w", encoding="utf-8"))
    os.dup2(2, 1)
    lines = _lines(_jobs())
    settings = json.loads(next(lines))
    lockstep = Lockstep(
        record=Path(settings["record"]) if settings["record"] else None,
        agent_limit_s=settings["agent_limit_s"],
        heartbeat=output.heartbeat,
    )
    output.write({"kind": "ready"})
    for line in lines:
        try:
            for result in lockstep.play([match_from_json(one) for one in json.loads(line)]):
                output.write({"kind": "result", "result": result.to_json()})
        except MovingOutError as error:
            output.write({"kind": "stop", "reason": str(error)})
            return
        output.write({"kind": "done"})


class WorkerOutput:
    """Messages to the driver, one line each."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._is_writing = False

    def write(self, message: dict[str, Any]) -> None:
        self._is_writing = True
        try:
            self._stream.write(json.dumps(message) + "\n")
            self._stream.flush()
        finally:
            self._is_writing = False

    def heartbeat(self) -> None:
        """Say that this process lives. Called from a signal handler, too, which may interrupt a message: then that one
        says so, and a stream cannot be written to twice at once."""
        if not self._is_writing:
            self.write({"kind": "heartbeat"})


def _jobs() -> TextIO:
    """Standard input, and an empty one in its place: an agent's `input()` or `breakpoint()` would wait for a job."""
    jobs, empty = os.fdopen(os.dup(0), encoding="utf-8"), os.open(os.devnull, os.O_RDONLY)
    os.dup2(empty, 0)
    os.close(empty)
    return jobs


def _lines(jobs: TextIO) -> Iterator[str]:
    """Lines of the jobs, read ahead by a thread. When they end, the driver has ended, perhaps killed, and this
    process exits at once, even within a match: another driver may be about to play and record the same match."""
    lines: queue.Queue[str] = queue.Queue()

    def read() -> None:
        for line in jobs:
            lines.put(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    while True:
        yield lines.get()
