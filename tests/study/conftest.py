"""The databases of the tests of studies."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from movingout.study.design import partner_speed
from tests.database import PostgresServer, postgres_server
from tests.study.support import OPENED


@pytest.fixture(autouse=True)
def close_stores() -> Iterator[None]:
    yield
    while OPENED:
        OPENED.pop().close()


@pytest.fixture(autouse=True)
def untimed_partners(monkeypatch: pytest.MonkeyPatch) -> None:
    """`study check` times the partners of every study, which takes seconds (tests/agents/test_decision_time.py)."""
    monkeypatch.setattr(partner_speed, "decision_ms", lambda agent_id, the_map: None)


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
