"""Who plays with whom, and who still waits for a partner. Reading is free; a change needs a transaction."""

import time
from collections import Counter
from collections.abc import Iterator, Sequence

from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.participant_session import ParticipantSession, notify
from movingout.server.study.participants import Participants
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.server.study.waiting_room import WaitingRoom
from movingout.study.design.allocation import assign
from movingout.study.design.definition import Study
from movingout.study.design.step_order import LAST_SOLO_STEP, WAITING, blocks_over, next_step
from movingout.study.design.steps import steps
from movingout.study.store import Unit
from movingout.study.store.rounds import LastRound


class Units:
    """The units that are taking part, by number, and the waiting room that pairs are formed from."""

    def __init__(self, study: Study, participants: Participants, databases: StudyDatabases, alerts: Alerts) -> None:
        self._study = study
        self._participants = participants
        self._databases = databases
        self._alerts = alerts
        self._units: dict[int, StudyUnit] = {}
        self.last_rounds: dict[int, LastRound] = {}  # the newest that has ended, by unit, also of finished units
        self._waiting_room = WaitingRoom(study.pairing.wait_s)

    def __iter__(self) -> Iterator[StudyUnit]:
        """As they are now; units may be formed and removed meanwhile."""
        return iter(list(self._units.values()))

    def get(self, number: int | None) -> StudyUnit | None:
        return None if number is None else self._units.get(number)

    def of(self, session: ParticipantSession) -> StudyUnit | None:
        """The unit of a participant; None before it is formed and after it has finished."""
        return self.get(session.record.unit)

    def last_round(self, session: ParticipantSession) -> LastRound | None:
        """The newest round of a participant's unit that has ended; another one may be running."""
        return None if session.record.unit is None else self.last_rounds.get(session.record.unit)

    async def restore(self, tx: Transaction) -> None:
        """Read the units that have not finished from the database, after the participants."""
        newest = await tx.run(self._databases.rounds.newest_episodes)
        left_out = await tx.run(self._databases.rounds.all_left_out)
        for record in await tx.run(self._databases.store.units_on_their_way):
            self._add(record, [self._participants[pid] for pid in record.pids], newest.get(record.id, ""))
            self._units[record.id].left_out = left_out.get(record.id, frozenset())

    def _add(self, record: Unit, members: Sequence[ParticipantSession], episode: str = "") -> None:
        size = self._study.group if record.dropped else len(members)  # an agent plays with one whom nobody has left
        unit = StudyUnit(record, list(members), size, paused_by_hand=record.paused, episode=episode)
        self._units[record.id] = unit
        for session in members:
            session.steps = steps(self._study, assign(self._study, record.slot))

    async def form(self, tx: Transaction, members: Sequence[ParticipantSession]) -> None:
        """Give one or two participants a slot, and move them to its first step.

        Who has no partner where the study is of pairs gets a slot beyond the planned ones, which are for pairs.
        """
        planned, whole = self._study.units, len(members) == self._study.group
        pids = [session.pid for session in members]
        record = await tx.run(self._databases.store.form_unit, pids, 0 if whole else planned)
        self._add(record, members)
        for session in members:
            await self._participants.refresh(tx, session)
        await self.move_to_first_step(tx, self._units[record.id])
        if whole and record.slot >= planned:
            slot = record.slot + 1
            self._alerts.add("full", f"More participants than planned: slot {slot} was given.", slot=slot)
        notify(members)

    async def move_to_first_step(self, tx: Transaction, unit: StudyUnit) -> None:
        """Repeated by the monitor, because a kill or a database error can come between the moves of a pair."""
        tx.check()
        for session in unit.members:
            if session.before_unit_steps:
                await self._participants.move(tx, session, next_step(session.steps, LAST_SOLO_STEP).key)

    def remove(self, tx: Transaction, unit: StudyUnit) -> None:
        """Forget a unit that has finished."""
        tx.check()
        del self._units[unit.record.id]

    async def blocks_over(self, tx: Transaction, unit: int) -> frozenset[str]:
        """The blocks whose time is up for a unit: their further rounds are left out.

        They stay over for the other one where somebody has the rounds of a pair deleted.
        """
        tx.check()
        if not any(block.limit_minutes for block in self._study.blocks):
            return frozenset()
        over = blocks_over(self._study, await tx.run(self._databases.rounds.block_seconds, unit))
        known = self.get(unit)
        if known is None:
            return over
        known.blocks_over |= over
        return known.blocks_over

    async def finished_steps(self, tx: Transaction, unit: int) -> frozenset[str]:
        """The keys of finished, valid rounds of a unit, also after they were deleted."""
        finished = await tx.run(self._databases.rounds.finished_steps, unit)
        known = self.get(unit)
        if known is None:
            return finished
        known.finished_steps = finished or known.finished_steps
        return known.finished_steps

    async def with_rounds_left(self, tx: Transaction, unit: StudyUnit) -> list[ParticipantSession]:
        """Who cannot finish without the others: somebody for whom rounds are still to come."""
        tx.check()
        found = [one for one in unit.members if not one.finished and one.has_rounds_left()]
        over = await self.blocks_over(tx, unit.record.id) if found else ()
        return [one for one in found if one.has_rounds_left(over)]

    # ---- waiting for a partner --------------------------------------------------------------------------------

    @property
    def waiting_count(self) -> int:
        return len(self._waiting_room)

    def waiting_since(self, session: ParticipantSession) -> float | None:
        """In seconds of the monotonic clock; None for somebody who is not waiting."""
        return self._waiting_room.since(session.pid)

    def heard(self, session: ParticipantSession, now: float) -> None:
        """A page of theirs is open: if they wait, they can be paired."""
        self._waiting_room.heard(session.pid, now)

    def stop_waiting(self, tx: Transaction, session: ParticipantSession) -> None:
        tx.check()
        self._waiting_room.leave(session.pid)

    def restart_waits(self, tx: Transaction) -> None:
        """All waits begin now: a pause does not count."""
        tx.check()
        self._waiting_room.restart_waits(time.monotonic())

    async def match(self, tx: Transaction) -> None:
        """Pair those who wait; after `wait_s` who is still here plays with an agent instead, or gets a code."""
        tx.check()
        now = time.monotonic()
        self._fill_waiting_room(now)
        while (pair := self._waiting_room.pair(now)) is not None:
            await self.form(tx, [self._participants[pid] for pid in pair])
        for pid in self._waiting_room.timed_out(now):
            session = self._participants[pid]
            here = session.present(now)
            if here and self._study.pairing.otherwise == "agent":
                await self.form(tx, [session])
            else:
                await self._participants.finish(tx, session, "no-partner" if here else "dropped-out")
                notify([session])
            self._waiting_room.leave(pid)

    def _fill_waiting_room(self, now: float) -> None:
        on_their_way = [one for one in self._participants if one.record.unit is None and not one.finished]
        at_screen = Counter(one.record.screen for one in on_their_way)
        coming = {one.record.screen for one in on_their_way if one.record.step != WAITING and one.present(now)} - {""}
        for session in on_their_way:
            if session.record.step == WAITING:
                screen = session.record.screen  # where the other one has left, they wait for anybody
                self._waiting_room.enter(session.pid, session.step_since, screen if at_screen[screen] > 1 else "")
                if screen in coming:
                    self._waiting_room.wait_anew(session.pid, now)
        for session in self._participants:
            if session.listeners and session.present(now):
                self._waiting_room.heard(session.pid, now)
