"""A real PostgreSQL for the tests: a private cluster on a loopback port, thrown away afterwards."""

import itertools
import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

PACKAGE = "postgresql"
ENDS_S = 120  # each of its programs, which need a second or two on a quiet machine
_COUNTER = itertools.count(1)


@dataclass(frozen=True)
class PostgresServer:
    """A running server; `address` is that of its first database."""

    address: str
    data: Path

    @property
    def pid(self) -> int:
        return int((self.data / "postmaster.pid").read_text().splitlines()[0])

    def new_database(self) -> str:
        """The address of an empty database."""
        import psycopg

        name = f"test_{os.getpid()}_{next(_COUNTER)}"
        with psycopg.connect(self.address, autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {name}")
        return self.address.rsplit("/", 1)[0] + f"/{name}"


@contextmanager
def postgres_server() -> Iterator[PostgresServer]:
    """For one `with` block; fails under CI=true, and skips elsewhere, where PostgreSQL is not installed."""
    programs = _programs_of_this_machine()
    folder = Path(tempfile.mkdtemp(prefix="movingout-pg-"))
    if os.geteuid() == 0:
        shutil.chown(folder, "postgres")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    data, quiet = folder / "data", subprocess.DEVNULL
    initdb = [str(programs / "initdb"), "-D", str(data), "-A", "trust", "-U", "tester", "--no-sync"]
    subprocess.run(_as_user(initdb), check=True, stdout=quiet, cwd=folder, timeout=ENDS_S)
    options = f"-h 127.0.0.1 -p {port} -k {folder} -c fsync=off"
    control = [str(programs / "pg_ctl"), "-D", str(data), "-w", "-l", str(folder / "log")]
    subprocess.run(_as_user([*control, "-o", options, "start"]), check=True, stdout=quiet, cwd=folder, timeout=ENDS_S)
    try:
        yield PostgresServer(f"postgresql://tester@127.0.0.1:{port}/postgres", data)
    finally:
        subprocess.run(
            _as_user([*control, "-m", "immediate", "stop"]), check=True, stdout=quiet, cwd=folder, timeout=ENDS_S
        )
        os.spawnlp(os.P_NOWAIT, "rm", "rm", "-rf", str(folder))  # nobody waits: hundreds of databases, 100,000 files


def _programs_of_this_machine() -> Path:
    ci = os.environ.get("CI") == "true"
    if _programs() is None and ci and os.geteuid() == 0:
        _install()
    programs = _programs()
    if programs is None:
        sentence = "PostgreSQL is not on this machine; install Debian's postgresql to run the tests against it"
        if ci:
            pytest.fail(f"{sentence}, as CI=true asks for")
        pytest.skip(sentence)
    return programs


def _programs() -> Path | None:
    """The folder with initdb; Debian keeps it out of the path."""
    found = shutil.which("initdb")
    if found:
        return Path(found).parent
    return next((path.parent for path in sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), reverse=True)), None)


def _install() -> None:
    for arguments in (["update", "-qq"], ["install", "-y", "-qq", "--no-install-recommends", PACKAGE]):
        environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        subprocess.run(["apt-get", *arguments], check=True, env=environment, stdout=subprocess.DEVNULL, timeout=600)


def _as_user(command: list[str]) -> list[str]:
    """PostgreSQL refuses to run as root; its package comes with a user."""
    return ["runuser", "-u", "postgres", "--", *command] if os.geteuid() == 0 else command
