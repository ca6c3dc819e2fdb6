"""Workers as processes: which silence is taken for a hang."""

import os
import queue
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import pytest

from movingout.matches.execution import local_workers
from movingout.matches.execution.local_workers import LocalWorkerPool

SILENCE_S = 50.0


class _Process:
    """A worker that says it is ready and has played, as soon as somebody listens."""

    def __init__(self, number: int, settings: str, inbox: "queue.Queue[tuple[int, _Process, str]]") -> None:
        for line in ('{"kind": "ready"}', '{"kind": "done"}'):
            inbox.put((number, self, line))

    def write(self, line: str) -> None:
        """It plays whatever it is sent."""

    def end(self) -> None:
        """Killed."""


def _first_message(monkeypatch: pytest.MonkeyPatch, times: Sequence[float], workers: int = 1) -> str:
    """Where the clock shows these times: sent, looked, waits, has waited, ready, looked, waits, has waited, done."""
    monkeypatch.setattr(local_workers, "_WorkerProcess", _Process)
    monkeypatch.setattr(local_workers, "time", SimpleNamespace(monotonic=iter(times).__next__))
    pool = LocalWorkerPool(workers, SILENCE_S, None, grace_s=0.0)
    for worker in range(workers):
        pool.send(worker, [])
    return pool.next_message().kind


def test_a_worker_that_is_slow_to_start_on_a_busy_machine_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _first_message(monkeypatch, [0, 300, 300, 301, 301, 302, 302, 303, 303]) == "done"


def test_one_that_never_starts_or_is_silent_while_it_plays_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _first_message(monkeypatch, [0, 2000]) == "died"
    assert _first_message(monkeypatch, [0, 1, 1, 2, 2, 2 + SILENCE_S + 1]) == "died"


def test_after_a_command_was_stopped_and_goes_on_its_workers_are_heard_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """As by Ctrl-Z, or where a cluster suspends a job: the matches of every worker counted as failed."""
    assert _first_message(monkeypatch, [0, 0, 1, 1, 1001, 1001, 1002, 1002, 1003, 1003], workers=2) == "done"


def test_ctrl_c_at_the_terminal_does_not_end_a_worker_that_still_imports(tmp_path: Path) -> None:
    package = tmp_path / "movingout" / "matches" / "execution"
    package.mkdir(parents=True)
    interrupted = "import os, signal; os.kill(os.getpid(), signal.SIGINT)"
    (package / "worker.py").write_text(f"{interrupted}\ndef main():\n    print('plays')\n")
    command = [sys.executable, "-S", "-P", "-c", local_workers.PROGRAM]  # -S: only the package above
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (ended.stdout, ended.stderr) == ("plays\n", "")
