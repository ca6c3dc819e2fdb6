"""Who opens a page of the study: the same person again, or somebody new; and for whom a browser's secret speaks."""

import secrets
from typing import Literal

from movingout.server.security.tokens import hash_token, new_token
from movingout.server.study.arrival_link import CODE, Arrival, ArrivalRefused
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy

Elsewhere = Literal["elsewhere"]


class SessionService:
    """Secrets are random and kept as hashes: the newest in the database, all of this run in memory."""

    def __init__(self, running: RunningStudy) -> None:
        self._running = running
        self._sessions: dict[str, ParticipantSession] = {}  # by the hash of the secret
        self._superseded: set[str] = set()

    async def arrive(self, arrival: Arrival, language: str, beside: str = "") -> tuple[str, ParticipantSession]:
        """A new secret for the page, and the participant, who is where they were. Raises ArrivalRefused.

        `beside` is the secret of the first person where two sit at one screen.
        """
        running = self._running
        first = await self.of_token(beside) if beside else None
        async with running.lock:
            pid = await self._pid(arrival)
            session = running.sessions.get(pid) or await self._welcome(pid, arrival.source, language)
            if arrival.source == CODE and session.finished:
                raise ArrivalRefused("code_used", "This code was used already, by somebody who has finished.")
            if session.listeners:
                running.alerts.raise_("duplicate", f"{pid} was opened in a second window; the first one was closed.")
            if isinstance(first, ParticipantSession):
                await self._seat_beside(first, session)
            token = new_token()
            await self._open_session(session, token)
            return token, session

    async def of_token(self, token: str) -> ParticipantSession | Elsewhere | None:
        """Who a secret speaks for; "elsewhere" when the study was opened in another window since."""
        digest = hash_token(token).hex()
        if digest in self._superseded:
            return "elsewhere"
        if digest not in self._sessions:
            pid = await self._running.run(self._running.databases.identities.of_session, digest)
            if pid is None or pid not in self._running.sessions:
                return None
            self._sessions[digest] = self._running.sessions[pid]
        session = self._sessions[digest]
        self._hear(session)
        return session

    async def new_code(self) -> str:
        """A code that lets one participant in."""
        code = secrets.token_hex(3).upper()
        await self._running.run(self._running.databases.identities.pid, CODE, code)
        return code

    async def _pid(self, arrival: Arrival) -> str:
        identities = self._running.databases.identities
        known = await self._running.run(identities.known, arrival.source, arrival.external_id)
        if known is not None:
            return known
        if arrival.source == CODE:
            raise ArrivalRefused("code_unknown", "This code is not known. Please check it, or ask the experimenter.")
        self._refuse_when_full()  # before anything is kept of them
        pid, _ = await self._running.run(identities.pid, arrival.source, arrival.external_id, arrival.parameters)
        return pid

    def _refuse_when_full(self) -> None:
        done = sum(session.record.outcome == "done" for session in self._running.sessions.values())
        if done >= self._running.study.participants:
            raise ArrivalRefused("study_full", "This study has as many participants as it needs. Thank you for coming!")

    async def _welcome(self, pid: str, source: str, language: str) -> ParticipantSession:
        running = self._running
        self._refuse_when_full()
        offered = running.study.languages
        chosen = language if language in offered else offered[0]
        return running.add(await running.run(running.databases.store.arrive, pid, chosen), source)

    async def _seat_beside(self, first: ParticipantSession, second: ParticipantSession) -> None:
        """The two will play with each other, where neither has a partner yet."""
        if (
            first is second
            or self._running.study.group < 2
            or any(one.record.unit is not None for one in (first, second))
        ):
            return
        running = self._running
        screen = first.record.screen or secrets.token_hex(4)
        await running.run(running.databases.store.sit_together, [first.pid, second.pid], screen)
        for session in (first, second):
            await running.refresh(session)
            running.waiting.leave(session.pid)  # and enters again, to wait for the other alone

    async def _open_session(self, session: ParticipantSession, token: str) -> None:
        digest = hash_token(token).hex()
        await self._running.run(self._running.databases.identities.open_session, session.pid, digest)
        for old in [one for one, known in self._sessions.items() if known is session]:
            del self._sessions[old]
            self._superseded.add(old)
        self._sessions[digest] = session
        listeners, session.listeners = session.listeners, []
        for push in listeners:
            push({"changed": True})  # they ask, and are told that the study is open elsewhere
        self._hear(session)

    def _hear(self, session: ParticipantSession) -> None:
        """A page of theirs is open."""
        session.last_seen_at = self._running.now()
        self._running.waiting.heard(session.pid, session.last_seen_at)
