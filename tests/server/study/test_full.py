"""When a study needs nobody more: by the slots that are done, open and held."""

from collections.abc import Collection
from types import SimpleNamespace
from typing import Any

import pytest

from movingout.server.study.participants import Participants
from movingout.study.design.study_file import parse_study
from movingout.study.store.store import DoneUnit
from tests.server.study.support import PAIR

STUDY = parse_study(PAIR.replace("participants: 400", "participants: 4"))  # two pairs


def done(*slots: int, size: int = 2, unwanted: Collection[int] = ()) -> Participants:
    """A study whose units at these slots are done; the data of some is not wanted."""
    databases: Any = SimpleNamespace(store=None, identities=None)
    participants = Participants(STUDY, databases)
    participants._done_units = tuple(DoneUnit(id=slot, slot=slot, size=size) for slot in slots)
    participants._sessions = {
        str(slot): SimpleNamespace(record=SimpleNamespace(unit=slot, keep=slot not in unwanted))  # type: ignore[misc]
        for slot in slots
    }
    return participants


@pytest.mark.parametrize(
    ("slots", "held", "full"),
    [
        ((), (), False),
        ((), (0, 1), False),
        ((0,), (1,), False),
        ((0, 1), (), True),
        ((0, 2), (), False),
        ((0, 2), (1,), True),
        ((2, 3), (0,), False),
        ((2, 3), (0, 1), True),
    ],
    ids=[
        "nobody came",
        "all are on their way",
        "one is done, one on the way",
        "all planned slots are done",
        "as many as planned, one slot open",
        "as many as planned, somebody on the open slot",
        "as many beyond the plan, one slot open",
        "as many beyond the plan, all slots held",
    ],
)
def test_a_study_is_full_once_enough_are_done_and_no_planned_slot_is_open(
    slots: tuple[int, ...], held: tuple[int, ...], full: bool
) -> None:
    assert done(*slots).is_full(held) is full


def test_who_plays_with_an_agent_in_a_partners_place_fills_no_planned_slot() -> None:
    assert not done(2, 3, size=1).is_full((0, 1))


def test_who_wants_their_data_deleted_leaves_their_place_to_another() -> None:
    assert not done(0, 1, unwanted=[1]).is_full(())
    assert done(0, 1, 2, unwanted=[1]).is_full([1]), "and somebody has it"
