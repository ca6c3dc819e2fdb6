"""Rounds of a server that is gone whose recordings are still being finished, by this server or another one.

Nobody else waits for them; their unit plays on when it is known how they ended, or it would play one twice.
"""

import time
from collections.abc import Awaitable, Callable

from movingout.server.study.participant_session import notify
from movingout.server.study.rounds.round_recovery import FINISHED_S, RoundRecovery
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.server.study.units import Units
from movingout.study.store.rounds import RoundOutcome


class LateRounds:
    """`on_recovered` moves a unit on when the end of its round is in the database."""

    def __init__(
        self, recovery: RoundRecovery, on_recovered: Callable[[Transaction, StudyUnit], Awaitable[None]]
    ) -> None:
        self._recovery = recovery
        self._on_recovered = on_recovered
        self._late: dict[str, tuple[int, float]] = {}  # units by episode, and since when, of the monotonic clock

    def add(self, episode: str, unit: int) -> bool:
        """Whether the recording of this round is still to come."""
        if self._recovery.is_coming(episode):
            self._late[episode] = unit, time.monotonic()
        return episode in self._late

    @property
    def episodes(self) -> dict[str, int]:
        """Units by episode."""
        return {episode: unit for episode, (unit, _) in self._late.items()}

    def goes_on(self, episode: str) -> None:
        """Of a round whose room is there after all."""
        self._late.pop(episode, None)

    def problem_of(self, unit: StudyUnit) -> str:
        late = any(number == unit.record.id for number, _ in self._late.values())
        return "The last round is still being saved." if late else ""

    async def save(self, tx: Transaction, units: Units, now: float) -> list[RoundOutcome]:
        """Save those that have come, and those that do not come; how they ended."""
        found = []
        for episode, (number, since) in list(self._late.items()):
            if self._recovery.is_coming(episode) and now - since < FINISHED_S:
                continue
            unit = units.get(number)
            found.append(await self._recovery.save(tx, episode, unit))
            del self._late[episode]
            if unit is not None:
                await self._move_on(tx, unit)
        return found

    async def _move_on(self, tx: Transaction, unit: StudyUnit) -> None:
        before = [session.record.step for session in unit.members]
        await self._on_recovered(tx, unit)
        if [session.record.step for session in unit.members] != before:
            unit.ready.clear()  # for a round that they have played
            unit.problem = ""
        notify(unit.members)
