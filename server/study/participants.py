"""Everybody who takes part, and the step each of them is at. Reading is free; a change needs a transaction."""

import secrets
import time
from collections import deque
from collections.abc import Collection, Iterator, Mapping

from movingout.server.study.databases import StudyDatabases
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.transaction import Transaction
from movingout.study.design.allocation import assign
from movingout.study.design.definition import Outcome, Study
from movingout.study.design.step_order import LAST_SOLO_STEP, WAITING
from movingout.study.design.steps import steps
from movingout.study.errors import StoreError
from movingout.study.store.identity import UNMISTAKABLE
from movingout.study.store.removal import UNDECIDED_S, decline, drop_undecided, undecided
from movingout.study.store.store import DoneUnit, Participant, planned_done

CODE_LENGTH = 10
CLOCK_MS = 5000  # by which the clock of another node, or one that was corrected, may be behind without a word
MOST_UNDECIDED = 2000  # of them are remembered after they have closed the page
MOST_DECLINED = 1000  # whose pages still say goodbye
MOST_AT_ONCE = 500  # deleted a second; more than can arrive
SCRUB_S = 60.0  # between two times at which a database overwrites what was deleted


class Participants:
    """The sessions by pseudonym. Each change is in the database before it is seen here."""

    def __init__(self, study: Study, databases: StudyDatabases) -> None:
        self._study = study
        self._store = databases.store
        self._databases = databases
        self._identities = databases.identities
        self._sessions: dict[str, ParticipantSession] = {}
        self._done_units: tuple[DoneUnit, ...] = ()
        self._unscrubbed = False  # whether identities were deleted since their database was scrubbed
        self._scrub_at = time.monotonic() + SCRUB_S
        self._declined = deque[ParticipantSession](maxlen=MOST_DECLINED)
        self._first_steps = steps(study, assign(study, 0))  # the same for every slot until the unit is formed

    def __iter__(self) -> Iterator[ParticipantSession]:
        """In the order of arrival."""
        return iter(self._sessions.values())

    def __getitem__(self, pid: str) -> ParticipantSession:
        return self._sessions[pid]

    def get(self, pid: str) -> ParticipantSession | None:
        return self._sessions.get(pid)

    async def restore(self, tx: Transaction, sources: Mapping[str, str]) -> float:
        """Read everybody from the database after a start; `sources` says by pseudonym who recruited them.

        Returns for how many seconds the clock was set back meanwhile, as far as anybody's times tell.
        """
        back_s = await self._follow_clock(tx)
        waiting = await tx.run(undecided, self._store)
        for record in await tx.run(self._store.everybody):
            session = self._add(record, sources.get(record.pid, ""))
            session.consented = record.pid not in waiting
            session.present_since = session.last_seen_at  # who comes back first waits from the start on
            seen_ms = record.last_seen_ms
            if seen_ms is None and not session.has_consented:
                seen_ms = record.arrived_ms  # within the last minute, or in data of earlier versions
            if record.step == LAST_SOLO_STEP:
                session.refused = await tx.run(self._store.refusal, record.pid)
            if seen_ms is not None:
                session.away_before_s = max(0.0, (self._store.now() - seen_ms) / 1e3)
        self._done_units = await tx.run(self._store.done_units)
        self._unscrubbed = await tx.run(self._identities.database.is_unscrubbed)
        return back_s

    async def _follow_clock(self, tx: Transaction) -> float:
        """Move the times of those on their way who, by a clock that was set back, would be paid for nothing."""
        now = self._store.now()
        on_their_way = [one for one in await tx.run(self._store.everybody) if one.code is None]
        ahead = {one.pid: max(one.arrived_ms, one.last_seen_ms or 0) - now for one in on_their_way}
        ahead = {pid: ms for pid, ms in ahead.items() if ms > CLOCK_MS}
        if ahead:
            await tx.run(self._store.set_back, ahead)
        return max(ahead.values(), default=0) / 1e3

    async def arrive(self, tx: Transaction, pid: str, language: str, source: str) -> ParticipantSession:
        """Somebody takes part from now on."""
        return self._add(await tx.run(self._store.arrive, pid, language), source)

    def _add(self, record: Participant, source: str) -> ParticipantSession:
        now = time.monotonic()
        session = ParticipantSession(record, self._first_steps, last_seen_at=now, step_since=now, source=source)
        self._sessions[record.pid] = session
        return session

    async def decline(self, tx: Transaction, session: ParticipantSession) -> None:
        """No consent: delete everything about them; only the number of those who declined is kept."""
        await tx.run(decline, self._store, session.pid, self._identities.drop)
        self._unscrubbed = True
        session.declined = True
        self._declined.append(session)
        del self._sessions[session.pid]

    async def scrub_identities(self, now: float) -> None:
        """Overwrite the ids of those who did not agree, and notes about them, once in a while.

        Anybody with the link can decline often.

        In no transaction: it may take long, and wait for another program that reads them.
        """
        if self._unscrubbed and now >= self._scrub_at:
            self._scrub_at, self._unscrubbed = now + SCRUB_S, False
            try:
                await self._databases.run(self._identities.database.scrub)
                await self._databases.run(self._store.database.scrub_rest)
            except StoreError:  # the experimenter was alerted, and it is tried again
                self._unscrubbed = True

    async def drop_undecided(self, tx: Transaction, now: float) -> list[str]:
        """Forget who opened the link and left without an answer to the consent: a row stays only with a consent.

        Returns their pseudonyms.
        """
        pids = [session.pid for session in self._gone(now)[:MOST_AT_ONCE]]
        if not pids:
            return []
        consented = await tx.run(drop_undecided, self._store, pids, self._identities.drop_visitors)
        self._unscrubbed = True
        for pid in consented:  # although the query that wrote it down failed, as without an answer from the database
            self._sessions[pid].consented = True
        gone = [pid for pid in pids if pid not in consented]
        for pid in gone:
            del self._sessions[pid]
        return gone

    def _gone(self, now: float) -> list[ParticipantSession]:
        """Of those without a consent, who has been away too long; while they are many, whoever has no page open."""
        visitors = [one for one in self._sessions.values() if not one.has_consented]
        visitors.sort(key=lambda one: one.absent_s(now), reverse=True)
        surplus = max(0, len(visitors) - MOST_UNDECIDED)
        crowded = [one for one in visitors[:surplus] if not one.present(now)]
        # a page that is still open may come back after a stop, however long that was
        return crowded + [one for one in visitors[surplus:] if one.absent_s(now) - one.away_before_s > UNDECIDED_S]

    async def move(self, tx: Transaction, session: ParticipantSession, key: str) -> None:
        """To the step with this key."""
        await tx.run(self._store.move, session.pid, key)
        await self.refresh(tx, session)

    @property
    def complete_units(self) -> int:
        """How many of the planned slots are done: by units of whom nobody has left or wants their data deleted."""
        return planned_done(self._wanted_units, self._study.units, self._study.group)

    def is_full(self, held: Collection[int]) -> bool:
        """Whether nobody more is needed: all planned slots are done, or as many units are and somebody is on each open
        slot; `held` are the slots of those on their way."""
        planned = self._study.units
        whole = [one.slot for one in self._wanted_units if one.size == self._study.group]
        return self.complete_units >= planned or (len(whole) >= planned and {*range(planned)} <= {*whole, *held})

    @property
    def _wanted_units(self) -> list[DoneUnit]:
        unwanted = {one.record.unit for one in self if one.record.keep is False}
        return [one for one in self._done_units if one.id not in unwanted]

    async def note_absences(self, tx: Transaction) -> None:
        """Keep the absences that have ended since the last time."""
        tx.check()
        for session in [one for one in self if one.unpaid_s]:
            await self._note_absence(tx, session)

    async def _note_absence(self, tx: Transaction, session: ParticipantSession) -> None:
        unpaid_s = session.unpaid_s
        await tx.run(self._store.was_away, session.pid, unpaid_s)
        session.unpaid_s -= unpaid_s
        await self.refresh(tx, session)

    async def note_last_seen(self, tx: Transaction) -> None:
        """Keep until when everybody was here: an absence goes on over a stop of the server.

        Retention begins when somebody was heard: a pause ends absences, also of who has long gone.
        """
        tx.check()
        now, now_ms = time.monotonic(), self._store.now()
        on_their_way = [one for one in self if not one.finished]
        seen = {one.pid: now_ms - round(1e3 * one.away_s(now)) for one in on_their_way}
        heard = [one for one in on_their_way if one.heard]
        if seen:
            await tx.run(self._store.seen, seen, {one.pid for one in heard})
        for session in heard:
            session.heard = False

    async def finish(
        self, tx: Transaction, session: ParticipantSession, outcome: Outcome, paused: bool = False
    ) -> None:
        """Give them their only completion code; who is away ended when they were last seen, but in a pause."""
        if session.unpaid_s:
            await self._note_absence(tx, session)
        now = time.monotonic()
        away_s = 0.0 if paused else session.away_s(now)
        await tx.run(self._store.finish, session.pid, outcome, self._code(session, outcome), away_s)
        session.ended_at = now
        await self.refresh(tx, session)
        if session.record.unit is not None:
            self._done_units = await tx.run(self._store.done_units)

    def _code(self, session: ParticipantSession, outcome: Outcome) -> str:
        fixed = {} if self._study.codes == "unique" else self._study.codes
        code = fixed.get(outcome)
        if code is None and outcome == "dropped-out":
            code = fixed.get("withdrew")
            if code is None and session.record.step == WAITING:  # files of before have that of `no-partner` for them
                code = fixed.get("no-partner")
        return code or "".join(secrets.choice(UNMISTAKABLE) for _ in range(CODE_LENGTH))

    async def refresh(self, tx: Transaction, session: ParticipantSession) -> None:
        """Read their record from the database again."""
        before = session.record.step
        session.record = await tx.run(self._store.participant, session.pid)
        if session.record.step != before:
            session.step_since = time.monotonic()
