"""Rounds whose recordings another server still finishes."""

import asyncio
from typing import Any, cast

from movingout.server.study.rounds.late_rounds import LateRounds
from movingout.server.study.rounds.round_outcomes import NOT_RECORDED
from movingout.server.study.rounds.round_recovery import FINISHED_S, RoundRecovery
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.server.study.units import Units
from movingout.study.store.store import Unit


class Recovery:
    """Recordings that come when a test says so."""

    def __init__(self) -> None:
        self.coming = {"late"}
        self.saved: list[str] = []

    def is_coming(self, episode: str) -> bool:
        return episode in self.coming

    async def save(self, tx: Transaction, episode: str, unit: StudyUnit | None) -> Any:
        self.saved.append(episode)
        return NOT_RECORDED


class Member:
    def __init__(self) -> None:
        self.record = self
        self.step = "round 1"
        self.pid = "P1"
        self.listeners: list[Any] = []


def story(late: LateRounds, unit: StudyUnit, now: float) -> int:
    units = cast(Units, {7: unit})
    return len(asyncio.run(late.save(cast(Transaction, None), units, now)))


def test_a_unit_waits_for_its_round_and_moves_on_when_it_is_known() -> None:
    recovery, member = Recovery(), Member()
    unit = StudyUnit(Unit(7, 0, ("P1",), False), [cast(Any, member)], 1, ready={"P1"})

    async def moves(tx: Transaction, unit: StudyUnit) -> None:
        member.step = "questions"

    late = LateRounds(cast(RoundRecovery, recovery), moves)
    assert late.add("late", 7) and not late.add("there", 7)
    unit.problem = late.problem_of(unit)
    assert unit.problem and story(late, unit, now=0.0) == 0
    recovery.coming.clear()
    assert story(late, unit, now=0.0) == 1
    assert (recovery.saved, unit.problem, unit.ready, late.problem_of(unit)) == (["late"], "", set(), "")


def test_a_round_that_was_broken_off_is_played_again_by_whoever_is_ready() -> None:
    recovery, member = Recovery(), Member()
    unit = StudyUnit(Unit(7, 0, ("P1",), False), [cast(Any, member)], 1, ready={"P1"})

    async def stays(tx: Transaction, unit: StudyUnit) -> None: ...

    late = LateRounds(cast(RoundRecovery, recovery), stays)
    late.add("late", 7)
    assert story(late, unit, now=FINISHED_S / 2 - 1e9) == 0
    assert story(late, unit, now=1e12) == 1, "nobody waits for ever"
    assert unit.ready == {"P1"}


def test_a_round_whose_room_is_there_after_all_goes_on() -> None:
    recovery = Recovery()
    unit = StudyUnit(Unit(7, 0, ("P1",), False), [], 1)

    async def stays(tx: Transaction, unit: StudyUnit) -> None: ...

    late = LateRounds(cast(RoundRecovery, recovery), stays)
    late.add("late", 7)
    assert late.episodes == {"late": 7}
    late.goes_on("late")
    recovery.coming.clear()
    assert (story(late, unit, now=0.0), recovery.saved, late.problem_of(unit)) == (0, [], "")
