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

from movingout.agents.worker.thread_budget import ONE_THREAD
from movingout.matches.execution.dispatch import WorkerMessage
from movingout.matches.match import Match, match_to_json, result_from_json

_GRACE_S = 30.0  # how long after the agents' own limit a worker without a heartbeat is killed
_START_S = 900.0  # the same until it is ready: imports take minutes on a busy machine, which is no agent's fault
PROGRAM = (  # Ctrl-C is for the driver, which stops its workers, also while they still import
    "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); "
    "from movingout.matches.execution.worker import main; main()"
)
_AWAY_S = 5.0  # a second's wait that takes longer: everything stood still, as by Ctrl-Z or where a cluster suspends it


class _WorkerProcess:
    """A worker process and the thread that reads its output."""

    def __init__(self, number: int, settings: str, inbox: "queue.Queue[tuple[int, _WorkerProcess, str]]") -> None:
        paths = [path or str(Path.cwd()) for path in sys.path]
        environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": os.pathsep.join(paths)}
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", PROGRAM], env=environment, encoding="utf-8",
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip
        self._reader = threading.Thread(target=self._read_lines, args=(number, inbox), daemon=True)
        self._reader.start()
        self.write(settings)

    def write(self, line: str) -> None:
        """Write a line. A dead worker is noticed when its output ends, not here."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass

    def end(self) -> str:
        """Kill the process if it still runs; returns how it ended."""
        self._process.kill()
        code = self._process.wait()
        self._reader.join()
        for pipe in (self._process.stdin, self._process.stdout):
            try:
                if pipe is not None:
                    pipe.close()
            except BrokenPipeError:
                pass
        return exit_reason(code)

    def wait(self) -> str:
        """Wait for a process whose output has ended; returns how it ended."""
        code = self._process.wait()
        self.end()
        return exit_reason(code)

    def _read_lines(self, number: int, inbox: "queue.Queue[tuple[int, _WorkerProcess, str]]") -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            inbox.put((number, self, line))
        inbox.put((number, self, ""))


def exit_reason(code: int) -> str:
    """How a process ended, as a sentence, from its exit code."""
    if code == -signal.SIGKILL:
        return "the process was killed (SIGKILL: usually the machine was out of memory)"
    if code < 0:
        return f"the process was ended by {signal.Signals(-code).name}"
    return f"the process ended with exit code {code}"


class LocalWorkerPool:
    """A `WorkerPool` of processes on this machine, each started with its first job."""

    def __init__(self, size: int, agent_limit_s: float, record: Path | None, grace_s: float = _GRACE_S) -> None:
        self.size = size
        self._silence_s = agent_limit_s + grace_s
        self._settings = json.dumps(
            {"record": None if record is None else str(record.resolve()), "agent_limit_s": agent_limit_s}
        )
        self._inbox: queue.Queue[tuple[int, _WorkerProcess, str]] = queue.Queue()
        self._processes: dict[int, _WorkerProcess] = {}
        self._heard_at: dict[int, float] = {}  # of the workers with a job, monotonic time [s]
        self._starting: set[int] = set()  # workers that are not ready yet

    def send(self, worker: int, matches: Sequence[Match]) -> None:
        if worker not in self._processes:
            self._processes[worker] = _WorkerProcess(worker, self._settings, self._inbox)
            self._starting.add(worker)
        self._heard_at[worker] = time.monotonic()
        self._processes[worker].write(json.dumps([match_to_json(match) for match in matches]))

    def next_message(self) -> WorkerMessage:
        while True:
            silent = self._kill_silent()
            if silent is not None:
                return silent
            arrived = self._wait()
            if arrived is None or self._processes.get(arrived[0]) is not arrived[1]:
                continue  # a late message of a worker that was replaced
            found = self._read(*arrived)
            if found is not None:
                return found

    def close(self) -> None:
        for process in self._processes.values():
            process.end()
        self._processes.clear()

    def _wait(self) -> tuple[int, _WorkerProcess, str] | None:
        """The next line of a worker, if one comes within a second."""
        before = time.monotonic()
        try:
            arrived = self._inbox.get(timeout=1.0)
        except queue.Empty:
            arrived = None
        now = time.monotonic()
        if now - before > _AWAY_S:
            self._heard_at = dict.fromkeys(self._heard_at, now)
        return arrived

    def _read(self, worker: int, process: _WorkerProcess, line: str) -> WorkerMessage | None:
        self._heard_at[worker] = time.monotonic()
        self._starting.discard(worker)
        if not line:
            del self._processes[worker], self._heard_at[worker]
            return WorkerMessage(worker, "died", reason=process.wait())
        message = json.loads(line)
        if message["kind"] == "result":
            return WorkerMessage(worker, "result", result_from_json(message["result"]))
        if message["kind"] == "stop":
            return WorkerMessage(worker, "stop", reason=message["reason"])
        if message["kind"] == "done":
            del self._heard_at[worker]
            return WorkerMessage(worker, "done")
        return None

    def _kill_silent(self) -> WorkerMessage | None:
        """Kill a worker that has sent nothing for too long."""
        now = time.monotonic()
        for worker, heard_at in self._heard_at.items():
            if now - heard_at > (max(_START_S, self._silence_s) if worker in self._starting else self._silence_s):
                del self._heard_at[worker]
                self._processes.pop(worker).end()
                return WorkerMessage(
                    worker, "died", reason=f"the process gave no sign of life for {now - heard_at:.0f} s"
                )
        return None
