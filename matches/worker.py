"""A worker process: `python -m matches.worker`. Jobs come in on standard input, results go out, as lines of JSON.

A program of its own rather than a fork or spawn of the caller: it works from a notebook and from a script without a
main guard, and a crash in it is only a closed pipe to the other side. What agents print goes to standard error.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any, TextIO

from maps.errors import MovingOutError
from matches.lockstep import Lockstep
from matches.match import match_from_json


def main() -> None:
    """Play jobs until standard input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    settings = json.loads(sys.stdin.readline())
    lockstep = Lockstep(
        record=Path(settings["record"]) if settings["record"] else None,
        agent_limit_s=settings["agent_limit_s"],
        beat=lambda: _say(answers, {"kind": "beat"}),
    )
    _say(answers, {"kind": "ready"})
    for line in sys.stdin:
        try:
            for result in lockstep.play([match_from_json(one) for one in json.loads(line)]):
                _say(answers, {"kind": "result", "result": result.to_json()})
        except MovingOutError as error:
            _say(answers, {"kind": "stop", "reason": str(error)})
            return
        _say(answers, {"kind": "done"})


def _say(answers: TextIO, message: dict[str, Any]) -> None:
    answers.write(json.dumps(message) + "\n")
    answers.flush()


if __name__ == "__main__":
    main()
