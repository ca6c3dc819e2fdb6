"""`movingout study serve` in a separate process, which may be killed."""

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.server.live import Live


@dataclass
class StudyProcess:
    """`movingout study serve` in a separate process, with the interface of `Served` that visitors use."""

    process: "subprocess.Popen[str]"
    live: Live
    printed: str

    @property
    def token(self) -> str:
        """The experimenter's token."""
        found = re.search(r"Token\s+in (.+)", self.printed)
        assert found, self.printed
        return Path(found[1]).read_text(encoding="ascii").strip()

    def ask(self, action: str, **order: Any) -> None:
        """An action of the experimenter, which must succeed."""
        status, answer = self.live.call(f"/api/experimenter/{action}", order, self.token)
        assert status == 200, answer

    def state(self) -> dict[str, Any]:
        """The experimenter's page, at most a second old."""
        status, answer = self.live.call("/api/experimenter/state", token=self.token)
        assert status == 200, answer
        return dict(answer)


@contextmanager
def study_process(file: Path, data: Path, port: int, *options: str) -> Iterator[StudyProcess]:
    command = [sys.executable, "-m", "movingout.server.cli", "study", "serve", str(file), "--data", str(data)]
    command += ["--port", str(port), "--processes", "1", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            printed = ""
            while "Data" not in printed:
                line = process.stdout.readline()
                assert line, process.stderr and process.stderr.read()
                printed += line
            yield StudyProcess(process, Live(port, None, None), printed)  # type: ignore[arg-type]
        finally:
            process.kill()
            process.wait(20)
