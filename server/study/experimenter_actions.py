"""What the experimenter can do to a running study. Everything is kept in the audit or beside the data."""

from time import time
from typing import Any

import msgspec

from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.session_service import SessionService
from movingout.server.study.unit import StudyUnit
from movingout.study.errors import StudyError

PAYMENT_COLUMNS = ("source", "id", "pid", "outcome", "code", "minutes", "amount", "currency", "data_kept")


class ExperimenterRequest(msgspec.Struct):
    """The body of what the experimenter asks for: about whom, and why."""

    pid: str | None = None
    unit: int | None = None
    episode: str | None = None
    reason: str = ""
    text: str = ""


class ExperimenterActions:
    """The actions of the experimenter's screen."""

    def __init__(self, running: RunningStudy, session_service: SessionService) -> None:
        self._running = running
        self._session_service = session_service

    async def pause(self, request: ExperimenterRequest) -> None:
        """Stop the clock of one unit, or of everybody."""
        await self._set_paused(request, True)

    async def resume(self, request: ExperimenterRequest) -> None:
        await self._set_paused(request, False)

    async def _set_paused(self, request: ExperimenterRequest, paused: bool) -> None:
        running = self._running
        async with running.lock:
            unit = self._unit(request) if request.pid or request.unit is not None else None
            await self._audit("pause" if paused else "resume", request)
            await running.pause(paused, unit)

    async def restart_round(self, request: ExperimenterRequest) -> None:
        """The running round does not count; it is played again from its map card."""
        running = self._running
        async with running.lock:
            unit = self._unit(request)
            if unit.running_round is None:
                raise StudyError("no round is running there now")
            await self._audit("restart-round", request)
            running.rooms.close(unit, "The experimenter starts this round again.")
            await running.rooms.write_down(unit)

    async def kick(self, request: ExperimenterRequest) -> None:
        """The study ends for a participant, who gets a code."""
        async with self._running.lock:
            session = self._session(request)
            await self._audit("kick", request)
            await self._running.dismiss(session, "withdrew")

    async def invalid(self, request: ExperimenterRequest) -> None:
        """A round does not count."""
        episode = request.episode or self._unit(request).episode
        if not episode:
            raise StudyError("they have not played a round yet")
        await self._running.run(self._running.databases.rounds.mark, episode, False, request.reason)

    async def note(self, request: ExperimenterRequest) -> None:
        """Something to remember, of a participant or of the whole study."""
        running, text = self._running, (request.text or request.reason).strip()
        if not text:
            raise StudyError("a note says something")
        unit = request.unit if request.unit is not None else self._session(request).record.unit if request.pid else None
        pids = [
            session.pid for session in running.sessions.values() if unit is not None and session.record.unit == unit
        ]
        if request.unit is not None and not pids:
            raise StudyError(f"there is no unit {request.unit} here")
        await running.run(running.databases.store.note, text, unit)
        running.notes.insert(0, {"at": time(), "text": text, "pid": " and ".join(pids) or request.pid})

    async def open_next(self, request: ExperimenterRequest) -> dict[str, str]:
        """A code for whoever comes next, and the link with it."""
        code = await self._session_service.new_code()
        await self._audit("open-next", request)
        return {"code": code, "path": f"/study?code={code}"}

    async def payments(self) -> list[dict[str, Any]]:
        """One row for each who has a code: who they are where they were recruited, and what their time is worth."""
        running = self._running
        known = await running.run(running.databases.identities.everybody)
        await running.run(running.databases.store.audit, "experimenter", "payments")
        rows = []
        for session in running.sessions.values():
            if session.record.code is None:
                continue
            source, external_id = known.get(session.pid, ("", ""))
            worth = running.worth(session) or {"minutes": "", "amount": "", "currency": ""}
            about = {"source": source, "id": _plain(external_id), "pid": session.pid, "outcome": session.record.outcome}
            rows.append({**about, "code": session.record.code, **worth, "data_kept": session.record.keep is not False})
        return rows

    async def _audit(self, action: str, request: ExperimenterRequest) -> None:
        """The reason may say who it was: it goes beside the data, as a note, and not into the audit."""
        running = self._running
        unit = {} if request.unit is None else {"unit": request.unit}
        await running.run(running.databases.store.audit, "experimenter", action, request.pid or "", **unit)
        if request.reason.strip():
            reason = f"{action}: {request.reason.strip()}"
            await self.note(ExperimenterRequest(pid=request.pid, unit=request.unit, text=reason))

    def _session(self, request: ExperimenterRequest) -> ParticipantSession:
        session = self._running.sessions.get(request.pid or "")
        if session is None:
            raise StudyError(f"there is no participant {request.pid!r} here")
        return session

    def _unit(self, request: ExperimenterRequest) -> StudyUnit:
        """Whom an request is about. Raises StudyError when they do not play (yet)."""
        number = self._session(request).record.unit if request.pid else request.unit
        unit = self._running.units.get(-1 if number is None else number)
        if unit is None:
            raise StudyError("they have not come as far as the game, or have finished")
        return unit


def _plain(text: str) -> str:
    """What came in a link is no formula for a spreadsheet."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@", "\t", "\r") else text
