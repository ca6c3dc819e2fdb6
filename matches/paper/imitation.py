"""Whose actions are imitated in the recordings of a folder of tables."""

from collections.abc import Iterable, Sequence

from movingout.agents.data.dataset import SeatChoice, imitated_seats
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.episode import SeatKind


def seat_choice(kinds: Iterable[Sequence[SeatKind]], space: Workspace) -> SeatChoice:
    """As `train --seats`, given the kinds of the seats of each episode.

    Of given recordings with people in them, people alone are imitated, not the agents that they played with.
    """
    return imitated_seats(kinds) if space.given else "acting"
