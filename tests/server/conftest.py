"""One server for all tests that need nothing special of it."""

from collections.abc import Iterator

import pytest

from tests.server.live import Live, limits, serve


@pytest.fixture(scope="session")
def shared_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    many = limits(
        sockets_per_address=500,
        waiting_per_address=500,
        wrong_tokens_per_minute=100_000,
        rooms_per_address_per_minute=100_000,
        open_rooms_per_address=100_000,
        unjoined_rooms_per_address=100_000,
        connects_per_address_per_minute=100_000,
        map_checks_per_minute=100_000,
        map_solves_per_minute=100_000,
    )
    with serve(tmp_path_factory.mktemp("live"), many) as running:
        yield running


@pytest.fixture
def live(shared_server: Live) -> Iterator[Live]:
    yield shared_server
    shared_server.hang_up()
