"""Which of several processes a room lives in: its id says so, by the last letter.

For any number of processes every id has one home, so that rooms stay valid when the number changes between two runs.
"""

from movingout.server.security.tokens import ID_LETTERS, new_id


def home_of(room_id: str, processes: int) -> int:
    """The index of the process of a room; 0 for what is no id of a room."""
    return max(0, ID_LETTERS.find(room_id[-1:])) % processes


def new_id_at(index: int, processes: int) -> str:
    """A new id of a room that lives in this process."""
    while home_of(room_id := new_id(), processes) != index:
        pass
    return room_id
