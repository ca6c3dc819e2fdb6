"""What the experimenter can do to a running study. Every action leaves a row in the audit or a note."""

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import msgspec

from movingout.recordings.spreadsheet import safe_text
from movingout.server.notices import Notice
from movingout.server.study.arrivals.session_service import SessionService
from movingout.server.study.earnings import earnings
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.unit import StudyUnit
from movingout.study.errors import StudyError

RESTARTED = Notice("round_restarted", "The experimenter starts this round again.")
PAYMENT_COLUMNS = (
    *("source", "id", "pid", "outcome", "code", "minutes", "amount", "currency", "data_kept"),
    *("assignment", "task"),
)


def _assignment(parameters: Mapping[str, str]) -> dict[str, str]:
    """What a platform calls what is paid, and the task that it is of; empty elsewhere."""
    names = {"assignment": ("assignmentId", "SESSION_ID"), "task": ("hitId", "STUDY_ID")}
    given = {column: [parameters[name] for name in of if name in parameters] for column, of in names.items()}
    return {column: safe_text(found[0]) if found else "" for column, found in given.items()}


class ExperimenterRequest(msgspec.Struct):
    """The body of an action: whom or what it is about, and why."""

    pid: str | None = None
    unit: int | None = None
    episode: str | None = None
    hold: str | None = None  # of `pause` and `resume`: what its page calls the hold of a dialog
    reason: str = ""
    text: str = ""


class ExperimenterActions:
    """The actions of the experimenter's page. They raise StudyError for what is not there or cannot be done."""

    def __init__(self, running: RunningStudy, session_service: SessionService) -> None:
        self._running = running
        self._databases = running.databases
        self._session_service = session_service

    async def pause(self, request: ExperimenterRequest) -> None:
        """Pause one unit, or everybody; with `hold`, one unit for as long as a dialog is open."""
        await self._set_paused(request, True)

    async def resume(self, request: ExperimenterRequest) -> None:
        """Let one unit go on, or everybody; with `hold`, once nobody has paused the unit or holds it."""
        await self._set_paused(request, False)

    async def _set_paused(self, request: ExperimenterRequest, paused: bool) -> None:
        async with self._running.transaction() as tx:
            of_one = request.pid or request.unit is not None or request.hold is not None
            unit = self._unit(request) if of_one else None
            if unit is not None and not paused and request.hold is not None and request.hold not in unit.holds:
                return  # somebody let the unit go on, or the server was started again
            await self._audit("pause" if paused else "resume", request)
            await self._running.progress.set_paused(tx, paused, unit, request.hold)

    async def restart_round(self, request: ExperimenterRequest) -> None:
        """End the running round, which does not count; it is played again from its map card."""
        rooms = self._running.rooms
        async with self._running.transaction() as tx:
            unit = self._unit(request)
            if unit.running_round is None:
                raise StudyError("no round is running now")
            await self._audit("restart-round", request)
            await rooms.close(tx, unit, RESTARTED)
            await rooms.finished.save(tx, unit)

    async def kick(self, request: ExperimenterRequest) -> None:
        """End the study for a participant, who gets a code: of who withdrew, or of who did not come back.

        Of who has not consented nothing is kept, also not that it was them, nor why.
        """
        async with self._running.transaction() as tx:
            session = self._session(request)
            await self._audit("kick", request if session.has_consented else ExperimenterRequest())
            gone = session.stayed_away(time.monotonic(), self._running.study.pairing.return_s)
            await self._running.departures.dismiss(tx, session, "dropped-out" if gone else "withdrew")

    async def invalid(self, request: ExperimenterRequest) -> None:
        """Mark a round as invalid: it does not count. Without an episode, the last one that has ended."""
        await self._mark(request, False)

    async def valid(self, request: ExperimenterRequest) -> None:
        """A round that was marked as invalid counts again."""
        await self._mark(request, True)

    async def _mark(self, request: ExperimenterRequest, valid: bool) -> None:
        last_rounds = self._running.units.last_rounds
        async with self._running.transaction() as tx:
            episode = request.episode
            if not episode:
                unit = self._session(request).record.unit if request.pid else request.unit
                if unit not in last_rounds:
                    raise StudyError("they have not finished a round yet")
                episode = last_rounds[unit].episode
            number = await tx.run(self._databases.rounds.mark, episode, valid)
            if number in last_rounds and last_rounds[number].episode == episode:
                last_rounds[number] = replace(last_rounds[number], valid=valid)
        if reason := request.reason.strip():  # may say who it was: a note can be deleted, the audit cannot
            await self._running.notes.add(f"{'valid' if valid else 'invalid'}: {reason}", number, request.pid)

    async def note(self, request: ExperimenterRequest) -> None:
        """A note on a participant, a unit or the whole study."""
        text = (request.text or request.reason).strip()
        if not text:
            raise StudyError("the note is empty")
        unit = request.unit
        if unit is not None and not any(session.record.unit == unit for session in self._running.participants):
            raise StudyError(f"there is no unit {unit} here")
        if unit is None and request.pid:
            unit = self._session(request).record.unit
        await self._running.notes.add(text, unit, request.pid)

    async def allow_device(self, request: ExperimenterRequest) -> None:
        """Let a participant continue in another browser, once."""
        session = self._session(request)
        await self._audit("allow-device", request)
        session.any_device = True

    async def open_next(self, request: ExperimenterRequest) -> dict[str, str]:
        """A code for the next participant, and the link with it."""
        code = await self._session_service.new_code()
        await self._audit("open-next", request)
        return {"code": code, "path": f"/study?code={code}"}

    async def payments(self) -> list[dict[str, Any]]:
        """One row per completion code: the id at the recruitment platform, and what is due."""
        known = await self._databases.run(self._databases.identities.everybody)
        kept = await self._databases.run(self._databases.identities.parameters)
        await self._databases.run(self._databases.store.audit, "experimenter", "payments")
        finished = [session for session in self._running.participants if session.record.code is not None]
        return [
            self._payment(session, *known.get(session.pid, ("", ""))) | _assignment(kept.get(session.pid, {}))
            for session in finished
        ]

    def _payment(self, session: ParticipantSession, source: str, external_id: str) -> dict[str, Any]:
        record = session.record
        due = earnings(self._running.study, record) or {"minutes": "", "amount": "", "currency": ""}
        about = {"source": source, "id": safe_text(external_id), "pid": record.pid, "outcome": record.outcome}
        return {**about, "code": record.code, **due, "data_kept": record.keep is not False}

    async def _audit(self, action: str, request: ExperimenterRequest) -> None:
        """The reason may identify somebody: it becomes a note and does not enter the audit."""
        detail: dict[str, Any] = {} if request.unit is None else {"unit": request.unit}
        detail |= {} if request.hold is None else {"hold": True}  # of a dialog, beside pauses by hand
        await self._databases.run(self._databases.store.audit, "experimenter", action, request.pid or "", **detail)
        if request.reason.strip():
            reason = f"{action}: {request.reason.strip()}"
            await self.note(ExperimenterRequest(pid=request.pid, unit=request.unit, text=reason))

    def _session(self, request: ExperimenterRequest) -> ParticipantSession:
        session = self._running.participants.get(request.pid or "")
        if session is None:
            raise StudyError(f"there is no participant {request.pid!r} here")
        return session

    def _unit(self, request: ExperimenterRequest) -> StudyUnit:
        """The unit that a request is about. Raises StudyError before it is formed and after it has finished."""
        number = self._session(request).record.unit if request.pid else request.unit
        unit = self._running.units.get(number)
        if unit is None:
            raise StudyError("they have not reached the game yet, or have finished")
        return unit
