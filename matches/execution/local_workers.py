"""Workers as processes of this machine."""

import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path

from movingout.matches.execution.dispatch import News
from movingout.matches.match import Match, match_to_json, result_from_json

_GRACE_S = 30.0  # a silent worker has this long more than an agent's limit: its own clock should have broken it off
_ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


class _Process:
    """One worker and the thread that listens to it."""

    def __init__(self, number: int, settings: str, inbox: "queue.Queue[tuple[int, _Process, str]]") -> None:
        paths = [path or str(Path.cwd()) for path in sys.path]
        environment = {**os.environ, **_ONE_THREAD, "PYTHONPATH": os.pathsep.join(paths)}
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "movingout.matches.execution.worker"], env=environment, encoding="utf-8",
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip
        self._listener = threading.Thread(target=self._listen, args=(number, inbox), daemon=True)
        self._listener.start()
        self.say(settings)

    def say(self, line: str) -> None:
        """Write a line; a dead worker is noticed by its closed pipe, not here."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass

    def end(self) -> str:
        """Kill it if it still runs; says how it ended."""
        self._process.kill()
        code = self._process.wait()
        self._listener.join()
        for pipe in (self._process.stdin, self._process.stdout):
            try:
                if pipe is not None:
                    pipe.close()
            except BrokenPipeError:
                pass
        return code_in_words(code)

    def wait(self) -> str:
        """How a worker ended whose pipe is closed."""
        code = self._process.wait()
        self.end()
        return code_in_words(code)

    def _listen(self, number: int, inbox: "queue.Queue[tuple[int, _Process, str]]") -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            inbox.put((number, self, line))
        inbox.put((number, self, ""))


def code_in_words(code: int) -> str:
    """How a process ended, from its exit code."""
    if code == -signal.SIGKILL:
        return "the process was killed (SIGKILL: usually the machine was out of memory)"
    if code < 0:
        return f"the process was ended by {signal.Signals(-code).name}"
    return f"the process ended with exit code {code}"


class LocalCrew:
    """A `Crew` of processes, started when first needed."""

    def __init__(self, size: int, agent_limit_s: float, record: Path | None, grace_s: float = _GRACE_S) -> None:
        self.size = size
        self._silence_s = agent_limit_s + grace_s
        self._settings = json.dumps(
            {"record": None if record is None else str(record.resolve()), "agent_limit_s": agent_limit_s}
        )
        self._inbox: queue.Queue[tuple[int, _Process, str]] = queue.Queue()
        self._processes: dict[int, _Process] = {}
        self._heard_at: dict[int, float] = {}  # of the busy ones, monotonic [s]

    def send(self, worker: int, matches: Sequence[Match]) -> None:
        if worker not in self._processes:
            self._processes[worker] = _Process(worker, self._settings, self._inbox)
        self._heard_at[worker] = time.monotonic()
        self._processes[worker].say(json.dumps([match_to_json(match) for match in matches]))

    def news(self) -> News:
        while True:
            silent = self._silent()
            if silent is not None:
                return silent
            try:
                worker, process, line = self._inbox.get(timeout=1.0)
            except queue.Empty:
                continue
            if self._processes.get(worker) is not process:
                continue  # the last words of one that was replaced
            found = self._heard(worker, process, line)
            if found is not None:
                return found

    def close(self) -> None:
        for process in self._processes.values():
            process.end()
        self._processes.clear()

    def _heard(self, worker: int, process: _Process, line: str) -> News | None:
        self._heard_at[worker] = time.monotonic()
        if not line:
            del self._processes[worker], self._heard_at[worker]
            return News(worker, "died", reason=process.wait())
        message = json.loads(line)
        if message["kind"] == "result":
            return News(worker, "result", result_from_json(message["result"]))
        if message["kind"] == "stop":
            return News(worker, "stop", reason=message["reason"])
        if message["kind"] == "done":
            del self._heard_at[worker]
            return News(worker, "done")
        return None

    def _silent(self) -> News | None:
        """Whoever has said nothing for too long is killed."""
        now = time.monotonic()
        for worker, heard_at in self._heard_at.items():
            if now - heard_at > self._silence_s:
                del self._heard_at[worker]
                self._processes.pop(worker).end()
                return News(worker, "died", reason=f"the process gave no sign of life for {now - heard_at:.0f} s")
        return None
