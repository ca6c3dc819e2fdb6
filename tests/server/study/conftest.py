"""Two served studies for the tests that need nothing special: of people with agents, and of pairs."""

from collections.abc import Iterator

import pytest

from tests.server.study.support import PAIR, Served, served


@pytest.fixture(scope="session")
def served_solo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("solo")) as running:
        yield running


@pytest.fixture(scope="session")
def served_pair(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("pair"), PAIR) as running:
        yield running


@pytest.fixture
def solo(served_solo: Served) -> Iterator[Served]:
    yield served_solo
    served_solo.live.hang_up()


@pytest.fixture
def pair(served_pair: Served) -> Iterator[Served]:
    yield served_pair
    served_pair.live.hang_up()
    served_pair.later(served_pair.running.study.pairing.wait_s)  # nobody who is left over is paired in the next test
