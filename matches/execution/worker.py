"""A worker process, `python -m movingout.matches.execution.worker`: jobs in on stdin, results out, as JSON lines.

A program of its own rather than a fork or spawn of the caller: it works from a notebook and from a script without a
main guard, and a crash in it is only a closed pipe to the other side. What agents print goes to standard error.
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
    """Play jobs as long as there is a driver."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the driver's, which ends its workers
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    lines = _lines()
    settings = json.loads(next(lines))
    lockstep = Lockstep(
        record=Path(settings["record"]) if settings["record"] else None,
        agent_limit_s=settings["agent_limit_s"],
        beat=lambda: _say(answers, {"kind": "beat"}),
    )
    _say(answers, {"kind": "ready"})
    for line in lines:
        try:
            for result in lockstep.play([match_from_json(one) for one in json.loads(line)]):
                _say(answers, {"kind": "result", "result": result.to_json()})
        except MovingOutError as error:
            _say(answers, {"kind": "stop", "reason": str(error)})
            return
        _say(answers, {"kind": "done"})


def _lines() -> Iterator[str]:
    """Standard input, read ahead by a thread: when it ends, the driver has ended, perhaps killed. Then this process
    ends at once, in the middle of a match: another driver may be about to play it again, and to record it."""
    lines: queue.Queue[str] = queue.Queue()

    def read() -> None:
        for line in sys.stdin:
            lines.put(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    while True:
        yield lines.get()


def _say(answers: TextIO, message: dict[str, Any]) -> None:
    answers.write(json.dumps(message) + "\n")
    answers.flush()


if __name__ == "__main__":
    main()
