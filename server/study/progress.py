"""From step to step, and the pauses in between. Reading is free; a change needs a transaction."""

import time
from collections.abc import Awaitable, Callable, Collection
from contextlib import suppress

from movingout.server.study.databases import StudyDatabases
from movingout.server.study.participant_session import ParticipantSession, notify
from movingout.server.study.participants import Participants
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import FinishedRound, StudyUnit
from movingout.server.study.units import Units
from movingout.study.design.definition import Study
from movingout.study.design.step_order import next_step
from movingout.study.design.steps import Step
from movingout.study.errors import StoreError
from movingout.study.store.clock import slept_s
from movingout.study.store.rounds import PlayerOutcome

SLEEP_S = 1.0  # a shorter one is none; the two clocks are not read at one time


class Progress:
    """Moves participants on, unless the experimenter has paused them."""

    def __init__(
        self,
        study: Study,
        participants: Participants,
        units: Units,
        databases: StudyDatabases,
        hold: Callable[[Transaction, StudyUnit, bool], Awaitable[None]],
    ) -> None:
        self._hold = hold  # stops the clock of a unit's room, or lets it go on
        self._study = study
        self._participants = participants
        self._units = units
        self._databases = databases
        self._paused = False
        self._slept_s = slept_s()  # how much of the machine's sleep is noted

    # ---- from step to step ------------------------------------------------------------------------------------

    async def advance(self, tx: Transaction, session: ParticipantSession) -> None:
        """To the next step that is not left out, or to the completion code."""
        unit, known = session.record.unit, self._units.of(session)
        left_out = known.left_out if known else frozenset[str]()
        over, played = frozenset[str](), frozenset[str]()
        if unit is not None and (left_out or any(block.limit_minutes for block in self._study.blocks)):
            over = await self._units.blocks_over(tx, unit)
            played = await self._units.finished_steps(tx, unit)
        key = session.record.step
        step = next_step(session.steps, key, over, played, key in left_out)
        while step.key in left_out:
            step = next_step(session.steps, step.key, over, played, unplayable=True)
        if step.kind == "code":
            await self._participants.finish(tx, session, "done")
        else:
            await self._participants.move(tx, session, step.key)

    async def skip_round(self, tx: Transaction, unit: StudyUnit, step: Step) -> None:
        """Past a round that cannot be played, with the questions about it. It is kept as an invalid one.

        All who are there go together, and who comes later passes it: nobody waits there for a partner who is done.
        """
        seated = [PlayerOutcome(one.pid, unit.seat_of(step, one), one.device) for one in unit.members]
        await tx.run(self._databases.rounds.leave_out, unit.record, step, seated)
        unit.left_out |= {step.key}
        for session in unit.members_at(step):
            await self.advance(tx, session)
        notify(unit.members)

    async def round_ended(self, tx: Transaction, unit: StudyUnit, ended: FinishedRound) -> None:
        """A round or the practice is saved; one that was broken off is played again."""
        await self._note_last_round(tx, unit)
        for session in unit.members_at(ended.step) if ended.counts else []:
            await self.advance(tx, session)
        notify(unit.members)

    async def _note_last_round(self, tx: Transaction, unit: StudyUnit) -> None:
        self._units.last_rounds.update(await tx.run(self._databases.rounds.last_finished, unit.record.id))

    async def catch_up(self, tx: Transaction, unit: StudyUnit) -> None:
        """Move past rounds that are finished or left out in the database, where a kill came before the move."""
        await self._note_last_round(tx, unit)
        await self._move_past(tx, unit, await tx.run(self._databases.rounds.finished_steps, unit.record.id))

    async def catch_up_all(self, tx: Transaction) -> None:
        """The same for everybody after a start, with two queries, because others wait; and past a given consent."""
        finished = await tx.run(self._databases.rounds.all_finished_steps)
        self._units.last_rounds.update(await tx.run(self._databases.rounds.last_finished))
        for unit in self._units:
            await self._move_past(tx, unit, finished.get(unit.record.id, frozenset()))
        for session in [one for one in self._participants if one.consented and one.at_consent]:
            await self.advance(tx, session)

    async def _move_past(self, tx: Transaction, unit: StudyUnit, finished: Collection[str]) -> None:
        for session in unit.members:
            while not session.finished and (session.record.step in finished or session.record.step in unit.left_out):
                await self.advance(tx, session)

    # ---- pauses -----------------------------------------------------------------------------------------------

    @property
    def paused(self) -> bool:
        """Whether the whole study is paused."""
        return self._paused

    def is_paused(self, session: ParticipantSession) -> bool:
        """Whether this participant, or everybody, is paused."""
        unit = self._units.of(session)
        return self._paused or (unit is not None and unit.paused)

    async def restore(self, tx: Transaction) -> None:
        """After a start: what was paused stays paused. Rooms must have been resumed."""
        self._paused = await tx.run(self._databases.store.paused)
        for session in self._participants:
            if self.is_paused(session):
                session.away_before_s = 0.0  # a pause is no absence
        await self.hold_rooms(tx)

    async def set_paused(
        self, tx: Transaction, paused: bool, unit: StudyUnit | None = None, hold: str | None = None
    ) -> None:
        """Pause or resume a unit or everybody; a restart of the server changes nothing, but ends the holds of units."""
        tx.check()
        if hold is None:
            await tx.run(self._databases.store.pause, paused, None if unit is None else unit.record.id)
        self.note_sleep()
        if paused:
            self._end_absences(unit)
        if unit is None:
            self._paused = paused
        else:
            unit.set_paused(paused, hold)
        await self.hold_rooms(tx)
        self.note_standing(time.monotonic())
        if not paused:
            self._restart_waits(tx, unit)
        notify(self._participants)
        if not paused:
            with suppress(StoreError):  # it goes on already, and who is here is noted again within a minute
                # a server that is killed now must not take the pause for absence
                await self._participants.note_last_seen(tx)

    def note_sleep(self) -> None:
        """A laptop that slept was away for everybody, as at a stop of the server; a pause is no absence."""
        slept = slept_s() - self._slept_s
        if slept > SLEEP_S:
            self._slept_s += slept
            for session in self._participants:
                if not self.is_paused(session):
                    session.slept(slept, time.monotonic())

    def note_standing(self, now: float) -> None:
        """For the experimenter's page: since when each unit stands still."""
        for unit in self._units:
            running_round = unit.running_round
            by_player = running_round is not None and running_round.view.phase == "paused"
            unit.note_standing(self._paused or unit.paused or by_player, now)

    def _end_absences(self, unit: StudyUnit | None) -> None:
        """Absences end with a pause, unless it begins in another one."""
        now = time.monotonic()
        for session in self._participants if unit is None else unit.members:
            if not self.is_paused(session):
                session.pause_begins(now)

    def _restart_waits(self, tx: Transaction, unit: StudyUnit | None) -> None:
        """A pause does not count as absence, nor as time in the waiting room, where nobody of a unit is."""
        for session in self._participants if unit is None else unit.members:
            session.resumed_at = time.monotonic()
        if unit is None:
            self._units.restart_waits(tx)

    async def hold_rooms(self, tx: Transaction) -> None:
        """Stop the clocks of those who are paused, of nobody else. Repeated: a process that ends forgets it."""
        tx.check()
        for unit in self._units:
            await self._hold(tx, unit, self._paused or unit.paused)
