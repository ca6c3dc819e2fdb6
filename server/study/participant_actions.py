"""What each request of a participant does. Repeating a request changes nothing."""

import time
from collections.abc import Callable, Sequence

import msgspec

from movingout.server.notices import ErrorCode, Notice
from movingout.server.rooms import room_view
from movingout.server.study.participant_session import ParticipantSession, notify
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.study.design.consent_text import filled
from movingout.study.design.step_order import LAST_SOLO_STEP, WAITING
from movingout.study.design.steps import Step, partner_met
from movingout.study.errors import StudyError
from movingout.study.store.database import NUL

MAX_DEVICE_LENGTH = 16  # letters
LONGEST_MS = 30 * 86_400_000.0  # on a page; whoever sends more makes numbers of no use to an average
CONTROLS = ("up", "left", "down", "right", "grab", "backward")  # of the input check
PRACTICE_OVER = Notice("practice_over", "The practice is over.")


class StepRefused(StudyError):
    """What a participant sent does not complete the step; `code` is for the page."""

    def __init__(self, code: ErrorCode, message: str) -> None:
        super().__init__(message)
        self.code = code


class StepRequest(msgspec.Struct):
    """The body of POST /api/study/next: the step that is done, and what that step needs."""

    key: str
    boxes: list[str] = []
    rtt_ms: float = 0.0
    device: str = ""
    untried: list[str] = []  # controls that the input check was passed without
    keep: bool | None = None
    done: bool = False  # enough practice


class StudyAnswerRequest(msgspec.Struct):
    """The body of POST /api/study/answer."""

    key: str
    item: str
    value: int
    text: str = ""
    elapsed_ms: float = 0.0
    hidden_ms: float = 0.0


class ParticipantActions:
    """The requests of all participants."""

    def __init__(self, running: RunningStudy) -> None:
        self._running = running
        self._study = running.study
        self._store = running.databases.store

    async def complete_step(
        self, session: ParticipantSession, request: StepRequest, may_consent: Callable[[], bool]
    ) -> bool:
        """The participant has done the step `request.key`; any other step than the current one is ignored.

        Returns False for a consent that `may_consent`, which is asked for each new one, does not allow. Raises
        StepRefused where something is missing.
        """
        running = self._running
        if session.step is not None and request.key == session.step.key:
            await self.skip_unplayable(session)
        async with running.transaction() as tx:
            step = session.step
            if session.finished or step is None or request.key != step.key or running.progress.is_paused(session):
                return True
            if step.kind == "consent":
                return await self._consent(tx, session, request.boxes, may_consent)
            if step.kind == "input-check":
                await self._check_input(tx, session, request)
            elif step.kind in ("practice", "round"):
                await self._ready(tx, session, step, request.done)
            elif step.kind == "debrief":
                await self._debriefed(tx, session, request.keep)
            else:
                await self._refuse_unanswered(tx, session, step)
                await running.progress.advance(tx, session)
        return True

    async def skip_unplayable(self, session: ParticipantSession) -> None:
        """Past rounds whose map cannot be varied, of which the experimenter is told. Raises Busy.

        A round that is played after a restart has its map in its room.
        """
        running = self._running
        while session.step is not None and not (session.finished or running.progress.is_paused(session)):
            step, unit = session.step, running.units.of(session)
            if unit is None or unit.plays(step):
                return
            why = await running.rooms.prepare(step)
            if not why:
                return
            async with running.transaction() as tx:
                if running.units.of(session) is not unit or unit.plays(step):
                    return
                if session.record.step == step.key and not running.progress.is_paused(session):
                    number, name = unit.record.id, running.rooms.map_name(step)
                    text = f"Unit {number} skips a round, which is invalid: its map {name} cannot be varied."
                    running.alerts.add("unvaried", text, why, unit=number, map=name)
                    await running.progress.skip_round(tx, unit, step)

    async def _refuse_unanswered(self, tx: Transaction, session: ParticipantSession, step: Step) -> None:
        """Every scale and choice needs an answer, be it "I prefer not to answer": nobody is done without any."""
        if step.questionnaire:
            given = await tx.run(self._store.answers, session.pid, step.key)
            items = self._study.questionnaire(step.questionnaire).items
            if any(not item.is_text and item.id not in given for item in items):
                raise StepRefused("unanswered", "Some questions have no answer yet; it may be that you prefer none.")

    async def _consent(
        self, tx: Transaction, session: ParticipantSession, boxes: Sequence[str], may_consent: Callable[[], bool]
    ) -> bool:
        consent = self._study.consent
        if any(box.required and box.id not in boxes for box in consent.boxes):
            raise StepRefused("boxes", "Please tick the boxes that are required, or say that you do not agree.")
        language = session.record.language
        ticked = [box.id for box in consent.boxes if box.id in boxes]
        shown = filled(self._study, consent.text, language)
        if not await tx.run(self._store.has_consented, session.pid, consent.version):
            if not may_consent():
                return False
            await tx.run(self._store.consent, session.pid, consent.version, language, shown, ticked)
            session.consented = True
        await self._running.progress.advance(tx, session)
        return True

    async def _check_input(self, tx: Transaction, session: ParticipantSession, request: StepRequest) -> None:
        running, required, rtt_ms = self._running, self._study.gate, request.rtt_ms
        session.rtt_ms, session.device = rtt_ms, request.device[:MAX_DEVICE_LENGTH]
        if rtt_ms > required.rtt_ms:
            await self._refuse(tx, session, "slow")
            most = f"{rtt_ms:.0f} ms, at most {required.rtt_ms}"
            raise StepRefused("slow", f"This connection is too slow for the game: {most}.")
        if required.gamepad and request.device != "gamepad":
            await self._refuse(tx, session, "gamepad")
            raise StepRefused("gamepad", "This study needs a gamepad. Please connect one and move its stick.")
        untried = [control for control in CONTROLS if control in request.untried]
        if untried:
            await tx.run(self._store.audit, "participant", "input-check", session.pid, untried=untried)
            text = f"{session.pid} continued without trying: {', '.join(untried)}."
            running.alerts.add("controls", text, pid=session.pid, controls=untried)
        if self._study.group == 1:
            await running.units.form(tx, [session])
        else:
            await running.participants.move(tx, session, WAITING)
            await running.units.match(tx)

    async def _refuse(self, tx: Transaction, session: ParticipantSession, why: str) -> None:
        """Who then stops is screened out, also after a restart of the server."""
        if session.refused != why:
            await tx.run(self._store.audit, "participant", "refused", session.pid, why=why)
            session.refused = why

    async def _ready(self, tx: Transaction, session: ParticipantSession, step: Step, done: bool) -> None:
        """Ready for a round or for the practice, or `done` with practising."""
        rooms, unit = self._running.rooms, self._running.units.of(session)
        if unit is None:
            return
        await rooms.finished.save(tx, unit)
        if unit.finished_round is not None or session.record.step != step.key:
            return  # the last round is not saved yet, or it was this one
        if step.kind == "practice" and done:
            await self._finish_practice(tx, session, unit, step)
        elif unit.running_round is None or unit.running_round.step.key != step.key:
            unit.set_ready(session, time.monotonic())
            if unit.running_round is None and unit.all_ready(step):
                await rooms.open(tx, unit, step)
        notify(unit.others(session))

    async def _finish_practice(self, tx: Transaction, session: ParticipantSession, unit: StudyUnit, step: Step) -> None:
        """Enough practice for one; the other of a pair may play on alone."""
        await self._running.progress.advance(tx, session)
        running_round = unit.running_round
        if running_round is None or running_round.step.key != step.key:
            return
        rooms, seat = self._running.rooms, running_round.seats[session.pid]
        if unit.members_at(step):
            await rooms.ask(tx, unit, room_view.retire, seat)
        else:
            await rooms.ask(tx, unit, room_view.note_skip, seat)
            await rooms.close(tx, unit, PRACTICE_OVER)

    async def _debriefed(self, tx: Transaction, session: ParticipantSession, keep: bool | None) -> None:
        running = self._running
        if self._study.debrief is not None and self._study.debrief.ask_to_keep:
            if keep is None:
                raise StepRefused("keep", "Please say whether we may keep your data.")
            await tx.run(self._store.keep_data, session.pid, keep)
        await running.progress.advance(tx, session)
        if keep is False:
            running.departures.delete_data(session)

    async def answer(self, session: ParticipantSession, request: StudyAnswerRequest) -> None:
        """Save one answer, also when the page has moved on already. Raises AnswerError, StepRefused, StoreError.

        It moves nobody, so it does not wait for a transaction.
        """
        reached = session.steps[: session.steps_done() + 1]
        step = next((step for step in reached if step.key == request.key and step.questionnaire), None)
        if step is None or session.declined or (session.finished and session.record.keep is False):
            raise StepRefused("step", "This question is not asked (any more).")
        questionnaire = self._study.questionnaire(step.questionnaire, session.record.language)
        questionnaire.check_answer(request.item, request.value, request.text)
        unit = self._running.units.of(session)
        await self._running.databases.run(
            self._store.answer,
            pid=session.pid,
            step=step.key,
            questionnaire=step.questionnaire,
            partner=partner_met(step, unit.size if unit else 0),
            item=request.item,
            value=request.value,
            text=request.text.replace(NUL, ""),
            elapsed_ms=_bounded(request.elapsed_ms),
            hidden_ms=_bounded(request.hidden_ms),
        )

    async def set_language(self, session: ParticipantSession, language: str) -> None:
        """Another language from now on, where the study has it."""
        if language in self._study.languages and language != session.record.language and not session.declined:
            async with self._running.transaction() as tx:
                await tx.run(self._store.set_language, session.pid, language)
                await self._running.participants.refresh(tx, session)

    async def decline(self, session: ParticipantSession) -> None:
        """No consent; ignored once it is given."""
        async with self._running.transaction() as tx:
            if not (session.finished or session.has_consented):
                await self._running.departures.decline(tx, session)

    async def stop(self, session: ParticipantSession, keep: bool) -> None:
        """The participant stops, with or without the data; after the end it is only noted what becomes of the data."""
        async with self._running.transaction() as tx:
            refused = session.refused and session.record.step == LAST_SOLO_STEP
            await self._running.departures.dismiss(tx, session, "screened-out" if refused else "withdrew", keep)


def _bounded(milliseconds: float) -> float:
    """A time that a browser measured, between nothing and the longest that is believed."""
    return min(max(0.0, milliseconds), LONGEST_MS)
