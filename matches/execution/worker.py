"""A worker process, `python -m movingout.matches.execution.worker`: jobs on stdin, results on stdout, as JSON lines.

It is a program of its own rather than a fork of the caller, so that it works from a notebook and from a script without
a main guard, and so that a crash is no more than a closed pipe to the caller. What agents print goes to stderr.
"""

import json
import os
import queue
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TextIO

from movingout.maps.errors import MovingOutError
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.match import match_from_json


def main() -> None:
    """Play jobs until standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the driver, which stops its workers
    output = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    lines = _lines()
    settings = json.loads(next(lines))
    lockstep = Lockstep(
        record=Path(settings["record"]) if settings["record"] else None,
        agent_limit_s=settings["agent_limit_s"],
        heartbeat=lambda: _write(output, {"kind": "heartbeat"}),
    )
    _write(output, {"kind": "ready"})
    for line in lines:
        try:
            for result in lockstep.play([match_from_json(one) for one in json.loads(line)]):
                _write(output, {"kind": "result", "result": result.to_json()})
        except MovingOutError as error:
            _write(output, {"kind": "stop", "reason": str(error)})
            return
        _write(output, {"kind": "done"})


def _lines() -> Iterator[str]:
    """Lines of standard input, read ahead by a thread. When it ends, the driver has ended, perhaps killed, and this
    process exits at once, even within a match: another driver may be about to play and record the same match."""
    lines: queue.Queue[str] = queue.Queue()

    def read() -> None:
        for line in sys.stdin:
            lines.put(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    while True:
        yield lines.get()


def _write(output: TextIO, message: dict[str, Any]) -> None:
    output.write(json.dumps(message) + "\n")
    output.flush()


if __name__ == "__main__":
    main()
