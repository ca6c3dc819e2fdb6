"""A server for a rehearsal: `movingout study serve --rehearse` in a separate process, which may be killed."""

import re
import subprocess
import threading
from pathlib import Path
from typing import NamedTuple

from movingout.server.commands.with_parent import PROGRAM
from movingout.server.study_bots.study_client import SimulationError

START_S = 300.0  # a busy machine takes minutes; a server that fails ends at once
STOP_S = 60.0


class ServerAddress(NamedTuple):
    """Where the study is served."""

    base: str  # http://127.0.0.1:8000
    admin_token: str = ""


class RehearsalServer:
    """A context manager; `kill` and `start` inside it simulate a power cut."""

    def __init__(self, file: Path, data: Path, speed: float, slow_agents: bool = False) -> None:
        self.address = ServerAddress("")
        quiet = ["-W", "ignore:resource_tracker:UserWarning"]  # no warnings about what a killed server leaves behind
        program = [PROGRAM[0], *quiet, *PROGRAM[1:], "study", "serve", str(file)]
        self._command = [*program, "--data", str(data), "--rehearse", f"{speed:g}"]
        self._command += ["--slow-agents"] if slow_agents else []
        self._port = "0"
        self._process: subprocess.Popen[str] | None = None

    def __enter__(self) -> "RehearsalServer":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            self._process.terminate()
            self._wait()

    def start(self) -> None:
        """Start the server, again on the same port. Raises SimulationError when it does not start."""
        command = [*self._command, "--port", self._port]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        timer = threading.Timer(START_S, self._process.kill)
        timer.start()
        try:
            self.address = self._read_links(self._process, timer)
        finally:
            timer.cancel()
        self._port = self.address.base.rpartition(":")[2]

    def kill(self) -> None:
        """Like `kill -9`."""
        assert self._process is not None
        self._process.kill()
        self._wait()

    def _wait(self) -> None:
        assert self._process is not None
        try:
            self._process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for pipe in filter(None, (self._process.stdin, self._process.stdout)):
            pipe.close()
        self._process = None

    def _read_links(self, process: "subprocess.Popen[str]", timer: threading.Timer) -> ServerAddress:
        assert process.stdout is not None
        base = ""
        for line in process.stdout:
            if found := re.search(r"(https?://\S+?)/study\b", line):
                base = base or found[1]
            if found := re.search(r"Token\s+in (.+)", line):
                return ServerAddress(base, Path(found[1]).read_text(encoding="ascii").strip())
        self._wait()
        if timer.finished.is_set():
            raise SimulationError(
                f"the server for the rehearsal did not start within {START_S:g} s; this machine is too busy"
            )
        raise SimulationError("the server for the rehearsal did not start; the lines above say why")
