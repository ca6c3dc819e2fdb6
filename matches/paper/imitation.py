"""Whose actions are imitated in the recordings of a folder of tables."""

from collections.abc import Iterable, Sequence

from movingout.agents.data.dataset import SeatChoice
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.episode import SeatKind


def has_person(kinds: Sequence[SeatKind]) -> bool:
    """Whether a person acts in an episode, given the kinds of its seats, and can be imitated.

    Who is replayed acts no more; that training and tests share nobody is another question (`split.has_people`).
    """
    return "human" in kinds


def seat_choice(kinds: Iterable[Sequence[SeatKind]], space: Workspace) -> SeatChoice:
    """As `train --seats`, given the kinds of the seats of each episode.

    Of given recordings with people in them, people alone are imitated, not the agents that they played with.
    """
    return "human" if space.given and any(map(has_person, kinds)) else "acting"
