"""The database that the nodes of the tests share."""

from collections.abc import Iterator

import pytest

from tests.database import PostgresServer, postgres_server
from tests.server.cluster.clock import TestClock


@pytest.fixture(scope="session")
def database_server() -> Iterator[PostgresServer]:
    with postgres_server() as server:
        yield server


@pytest.fixture
def database(database_server: PostgresServer) -> str:
    """The address of an empty database."""
    return database_server.new_database()


@pytest.fixture
def clock(database: str) -> Iterator[TestClock]:
    clock = TestClock(database)
    yield clock
    clock.close()
