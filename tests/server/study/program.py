"""`movingout study serve` in a process of its own, which may be killed."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.server.live import Live


@dataclass
class Program:
    """`movingout study serve` in a process of its own; it offers a visitor what `Served` does."""

    process: "subprocess.Popen[str]"
    live: Live
    printed: str


@contextmanager
def program(file: Path, data: Path, port: int, *options: str) -> Iterator[Program]:
    command = [sys.executable, "-m", "server.cli", "study", "serve", str(file), "--data", str(data)]
    command += ["--port", str(port), *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            printed = ""
            while "Data" not in printed:
                line = process.stdout.readline()
                assert line, process.stderr and process.stderr.read()
                printed += line
            yield Program(process, Live(port, None, None), printed)  # type: ignore[arg-type]
        finally:
            process.kill()
            process.wait(20)
