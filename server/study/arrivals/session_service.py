"""Arrivals and tokens: who opens a page of the study, and which participant a browser's token stands for."""

import secrets
import time
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from typing import Literal, NamedTuple
from weakref import WeakValueDictionary

from movingout.server.connection.fair_queue import FairQueue
from movingout.server.security.tokens import hash_token, new_id, new_token
from movingout.server.study.arrivals.arrival_link import INVITED, LINK, Arrival, ArrivalRefused
from movingout.server.study.participant_session import ParticipantSession, notify
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.transaction import Transaction
from movingout.study.design.localized_text import nearest
from movingout.study.store.identity import CODE

SINCE = "."  # in a token, before the time from which on it shows texts
MOST_SUPERSEDED = 50_000  # pages that are told that the study is open elsewhere; older ones have to arrive again
LINK_CODE_LENGTH = 8  # 40 bits, which nobody guesses
Elsewhere = Literal["elsewhere"]


class Arrived(NamedTuple):
    """A page of a participant, who is where they were."""

    token: str
    session: ParticipantSession
    replaces: int | None  # which of the tokens that the browser had was theirs
    was_here: bool  # whether one of them is or ever was


class SessionService:
    """Random tokens, kept as hashes: the newest of each participant in the database, those of this run in memory."""

    def __init__(self, running: RunningStudy) -> None:
        self._running = running
        self._identities = running.databases.identities
        # By the hash of the token. Weak: who left without a consent is remembered by nobody.
        self._sessions = WeakValueDictionary[str, ParticipantSession]()
        self._superseded: dict[str, str] = {}  # whose they were, the oldest first
        self._queue = FairQueue()

    async def arrive(
        self, arrival: Arrival, language: str, beside: str = "", known: Sequence[str] = (), address: str = ""
    ) -> Arrived:
        """A new token for the page. Raises ArrivalRefused.

        `beside` is the token of the first person where two sit at one screen. `known` are the tokens that the browser
        has from before: whoever comes back without theirs may be anybody who knows the link, and is shown no old text.
        Addresses, as limits know them, take turns.
        """
        running = self._running
        first = await self.of_token(beside) if beside and running.study.pairing.one_screen == "on" else None
        here = [await self.of_token(token) for token in known]
        async with self._turn(address) as tx:
            if isinstance(first, ParticipantSession) and first.record.unit is not None:
                await self._refuse_new(tx, arrival)
            pid, is_new = await self._pid(tx, arrival)
            before = running.participants.get(pid)
            replaces = here.index(before) if before is not None and before in here else None
            if before is not None and replaces is None:
                self._refuse_other_device(before)
            session = before or await self._admit(tx, pid, arrival.source, language)
            if arrival.source == CODE and session.finished and replaces is None:  # their own page has their code
                raise ArrivalRefused("code_used", "This code was used already, by somebody who has finished.")
            if arrival.parameters and not (is_new or session.finished):
                # they took another assignment, or come for the first time with a code, which was made without any
                await tx.run(self._identities.keep_parameters, pid, arrival.parameters)
            if session.listeners:
                running.alerts.add("duplicate", f"{pid} opened a second window; the first one was closed.", pid=pid)
            if isinstance(first, ParticipantSession):
                await self._seat_beside(tx, first, session)
            if before is not None and replaces is None:
                session.texts_since_ms = running.databases.store.now()
                session.any_device = False  # it was allowed once
            token = _token(session.texts_since_ms)
            await self._open_session(tx, session, token)
            return Arrived(token, session, replaces, self._were_of(pid, known))

    async def arrival_beside(self, token: str) -> Arrival | None:
        """The one guest of somebody who was invited and plays at one screen with them; None for whoever may have none.

        A guest who asks again, because the answer was lost, is the same person. Raises ArrivalRefused where a partner
        has come.
        """
        first = await self.of_token(token)
        if not isinstance(first, ParticipantSession) or first.finished or first.source not in INVITED:
            return None
        if self._running.study.group < 2 or self._running.study.pairing.one_screen == "off":
            return None
        if first.record.unit is not None:
            raise _partner_came()
        id = hash_token(f"beside {first.pid}").hex()
        known = await self._running.databases.run(self._identities.known, LINK, id)
        guest = None if known is None else self._running.participants.get(known)
        return None if guest is not None and guest.finished else Arrival(LINK, id, {})

    def remembers(self, token: str) -> bool:
        """Whether `of_token` knows a token without asking the database."""
        digest = hash_token(token).hex()
        return digest in self._superseded or digest in self._sessions

    async def of_token(self, token: str) -> ParticipantSession | Elsewhere | None:
        """Whom a token stands for; "elsewhere" when the study was opened in another window since."""
        digest = hash_token(token).hex()
        if digest in self._superseded:
            return "elsewhere"
        session = self._sessions.get(digest)
        if session is None:
            pid = await self._running.databases.run(self._identities.of_session, digest)
            session = self._running.participants.get(pid) if pid is not None else None
            if session is None:
                return None
            self._sessions[digest] = session
            session.texts_since_ms = _since_ms(token)  # after a restart
        if self._running.participants.get(session.pid) is not session and not session.declined:
            return None  # they never consented, and were forgotten
        self._mark_present(session)
        return session

    async def new_code(self) -> str:
        """A code that lets one participant in."""
        code = new_id(LINK_CODE_LENGTH).upper()
        await self._running.databases.run(self._identities.pid, CODE, code)
        return code

    @asynccontextmanager
    async def _turn(self, address: str) -> AsyncIterator[Transaction]:
        """A transaction, for which one arrival waits at a time: a flood of them is not in front of everybody else."""
        asked = time.monotonic()
        async with self._queue.turn(address), self._running.transaction(asked) as tx:
            yield tx

    async def _refuse_new(self, tx: Transaction, arrival: Arrival) -> None:
        """Nobody can join somebody who has a partner; who has come before is where they were."""
        pid = await tx.run(self._identities.known, arrival.source, arrival.external_id)
        if self._running.study.group > 1 and (pid is None or self._running.participants.get(pid) is None):
            raise _partner_came()

    async def _pid(self, tx: Transaction, arrival: Arrival) -> tuple[str, bool]:
        """The pseudonym, and whether it is new, and what else the link said kept with it. Raises ArrivalRefused."""
        known = await tx.run(self._identities.known, arrival.source, arrival.external_id)
        if known is not None:
            return known, False
        if arrival.expired:
            raise ArrivalRefused("link_expired", "This link has expired. Please ask the experimenter for another one.")
        if arrival.source == CODE:
            raise ArrivalRefused("code_unknown", "This code is not known. Please check it, or ask the experimenter.")
        self._refuse_when_full()  # before anything about them is kept
        return await tx.run(self._identities.pid, arrival.source, arrival.external_id, arrival.parameters)

    def _refuse_other_device(self, session: ParticipantSession) -> None:
        if not self._running.device_bound(session):
            return
        pid = session.pid
        self._running.alerts.add(
            "other_device", f"{pid} wants to continue in another browser; you can allow it.", pid=pid
        )
        text = "You began this study in another browser. Please continue there, or ask the experimenter."
        raise ArrivalRefused("other_device", text)

    def _refuse_when_full(self) -> None:
        units = self._running.units
        held = {one.record.slot for one in units if not (one.finished or one.record.dropped)}
        if self._running.participants.is_full(held):
            raise ArrivalRefused("study_full", "This study has as many participants as it needs. Thank you for coming!")

    async def _admit(self, tx: Transaction, pid: str, source: str, language: str) -> ParticipantSession:
        self._refuse_when_full()
        offered = self._running.study.languages
        chosen = nearest(language, offered) or offered[0]
        return await self._running.participants.arrive(tx, pid, chosen, source)

    async def _seat_beside(self, tx: Transaction, first: ParticipantSession, second: ParticipantSession) -> None:
        """The two will play with each other, where neither has a partner yet."""
        running, both = self._running, (first, second)
        if first is second or running.study.group < 2 or any(one.record.unit is not None for one in both):
            return
        screen = first.record.screen or secrets.token_hex(4)
        await tx.run(running.databases.store.set_shared_screen, [first.pid, second.pid], screen)
        for session in both:
            await running.participants.refresh(tx, session)
            running.units.stop_waiting(tx, session)  # they wait anew, for each other

    async def _open_session(self, tx: Transaction, session: ParticipantSession, token: str) -> None:
        digest = hash_token(token).hex()
        await tx.run(self._identities.open_session, session.pid, digest)
        for old in [one for one, known in self._sessions.items() if known is session]:
            del self._sessions[old]
            self._superseded[old] = session.pid
        while len(self._superseded) > MOST_SUPERSEDED:
            del self._superseded[next(iter(self._superseded))]
        self._sessions[digest] = session
        notify([session])  # the other pages ask, and are told that the study is open elsewhere
        session.listeners = []
        self._mark_present(session)

    def _were_of(self, pid: str, tokens: Sequence[str]) -> bool:
        """Whether one of these tokens was somebody's, before the newest."""
        return any(self._superseded.get(hash_token(token).hex()) == pid for token in tokens)

    def _mark_present(self, session: ParticipantSession) -> None:
        """A page of theirs is open."""
        self._running.progress.note_sleep()
        session.seen(time.monotonic(), self._running.progress.is_paused(session))
        session.absence_told = False
        self._running.units.heard(session, session.last_seen_at)


def _partner_came() -> ArrivalRefused:
    return ArrivalRefused("partner_came", "You have a partner by now. Nobody can be added any more.")


def _token(since_ms: int) -> str:
    """A token that shows texts from this time on. Nobody can change the time in it, because its hash is kept."""
    return f"{new_token()}{SINCE}{since_ms}" if since_ms else new_token()


def _since_ms(token: str) -> int:
    return int(token.partition(SINCE)[2] or 0)
