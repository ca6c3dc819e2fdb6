"""The databases of the tests of studies."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.database import PostgresServer, postgres_server
from tests.study.support import OPENED


@pytest.fixture(autouse=True)
def close_stores() -> Iterator[None]:
    yield
    while OPENED:
        OPENED.pop().close()


@pytest.fixture(scope="session")
def cluster() -> Iterator[PostgresServer]:
    with postgres_server() as server:
        yield server


@pytest.fixture
def postgres(cluster: PostgresServer) -> str:
    """The address of an empty database."""
    return cluster.new_database()


@pytest.fixture(params=["sqlite", "postgresql"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> Path | str:
    """Where a store may lie: a folder for SQLite, an address of PostgreSQL."""
    return tmp_path if request.param == "sqlite" else str(request.getfixturevalue("postgres"))
