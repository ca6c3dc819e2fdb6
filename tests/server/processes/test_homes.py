"""Where a room lives follows from its id."""

import pytest

from movingout.server.processes.homes import home_of, new_id_at
from movingout.server.security.tokens import ID_LETTERS, new_id
from movingout.server.settings import MOST_PROCESSES


@pytest.mark.parametrize("processes", [1, 2, 3, 7, MOST_PROCESSES])
def test_a_new_room_lives_where_it_was_opened(processes: int) -> None:
    for index in range(processes):
        assert home_of(new_id_at(index, processes), processes) == index


def test_every_id_has_a_home_for_every_number_of_processes() -> None:
    assert len(ID_LETTERS) == MOST_PROCESSES
    ids = [new_id() for _ in range(50)] + ["", "x", "no-such-room", "ROOM", "räume"]
    assert all(0 <= home_of(room_id, processes) < processes for room_id in ids for processes in range(1, 33))
