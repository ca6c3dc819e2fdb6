"""A real PostgreSQL for the tests: a private cluster on a loopback port, thrown away afterwards."""

import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.study.support import OPENED

PACKAGE = "postgresql"
_COUNTER = iter(range(1, 1 << 20))


@pytest.fixture(autouse=True)
def close_stores() -> Iterator[None]:
    yield
    while OPENED:
        OPENED.pop().close()


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


@pytest.fixture(scope="session")
def cluster() -> Iterator[str]:
    """The address of the cluster's first database."""
    ci = os.environ.get("CI") == "true"
    if _programs() is None and ci and os.geteuid() == 0:
        _install()
    programs = _programs()
    if programs is None:
        sentence = "PostgreSQL is not on this machine; install Debian's postgresql to run the tests against it"
        if ci:
            pytest.fail(f"{sentence}, as CI=true asks for")
        pytest.skip(sentence)
    folder = Path(tempfile.mkdtemp(prefix="movingout-pg-"))
    if os.geteuid() == 0:
        shutil.chown(folder, "postgres")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    data, quiet = folder / "data", subprocess.DEVNULL
    initdb = [str(programs / "initdb"), "-D", str(data), "-A", "trust", "-U", "tester", "--no-sync"]
    subprocess.run(_as_user(initdb), check=True, stdout=quiet, cwd=folder)
    options = f"-h 127.0.0.1 -p {port} -k {folder} -c fsync=off"
    control = [str(programs / "pg_ctl"), "-D", str(data), "-w", "-l", str(folder / "log")]
    subprocess.run(_as_user([*control, "-o", options, "start"]), check=True, stdout=quiet, cwd=folder)
    try:
        yield f"postgresql://tester@127.0.0.1:{port}/postgres"
    finally:
        subprocess.run(_as_user([*control, "-m", "immediate", "stop"]), check=True, stdout=quiet, cwd=folder)
        shutil.rmtree(folder)


@pytest.fixture
def postgres(cluster: str) -> str:
    """The address of an empty database."""
    import psycopg

    name = f"study_{os.getpid()}_{next(_COUNTER)}"
    with psycopg.connect(cluster, autocommit=True) as connection:
        connection.execute(f"CREATE DATABASE {name}")
    return cluster.rsplit("/", 1)[0] + f"/{name}"


@pytest.fixture(params=["sqlite", "postgresql"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> Path | str:
    """Where a store may lie: a folder for SQLite, an address of PostgreSQL."""
    return tmp_path if request.param == "sqlite" else str(request.getfixturevalue("postgres"))
