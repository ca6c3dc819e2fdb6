"""What each request of a participant does. Asking twice for the same is harmless everywhere."""

from collections.abc import Sequence

import msgspec

from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.unit import StudyUnit
from movingout.study.design.step_order import LAST_ALONE, WAITING
from movingout.study.design.steps import Step
from movingout.study.errors import StudyError

MOST_DEVICE = 16  # letters


class StepRefused(StudyError):
    """What a participant sent does not do; `code` is for the page."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


class StepRequest(msgspec.Struct):
    """The body of POST /api/study/next: the step that is done, and what that step needs."""

    key: str
    boxes: list[str] = []
    rtt_ms: float = 0.0
    device: str = ""
    keep: bool | None = None
    done: bool = False  # practised enough


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

    async def go_on(self, session: ParticipantSession, request: StepRequest) -> None:
        """The participant has done the step `request.key`; a step that is over already is left alone."""
        running = self._running
        if session.step is not None and request.key == session.step.key:
            await running.rooms.prepare(session.step)
        async with running.lock:
            step = session.step
            if session.finished or step is None or request.key != step.key or running.stays(session):
                return
            if step.kind == "consent":
                await self._consent(session, request.boxes)
            elif step.kind == "input-check":
                await self._check_input(session, request.rtt_ms, request.device)
            elif step.kind in ("practice", "round"):
                await self._ready(session, step, request.done)
            elif step.kind == "debrief":
                await self._debriefed(session, request.keep)
            else:
                await running.advance(session)

    async def _consent(self, session: ParticipantSession, boxes: Sequence[str]) -> None:
        running, consent = self._running, self._running.study.consent
        if any(box.required and box.id not in boxes for box in consent.boxes):
            raise StepRefused("boxes", "Please tick the boxes that are required, or say that you do not agree.")
        language = session.record.language
        ticked = [box.id for box in consent.boxes if box.id in boxes]
        shown = consent.text.text(language)
        if not await running.run(running.databases.store.has_consented, session.pid, consent.version):
            await running.run(running.databases.store.consent, session.pid, consent.version, language, shown, ticked)
        await running.advance(session)

    async def _check_input(self, session: ParticipantSession, rtt_ms: float, device: str) -> None:
        running, gate = self._running, self._running.study.gate
        session.rtt_ms, session.device, session.refused = rtt_ms, device[:MOST_DEVICE], ""
        if rtt_ms > gate.rtt_ms:
            session.refused = "slow"
            most = f"{rtt_ms:.0f} ms, at most {gate.rtt_ms}"
            raise StepRefused(session.refused, f"This connection is too slow for the game: {most}.")
        if gate.gamepad and device != "gamepad":
            session.refused = "gamepad"
            raise StepRefused(session.refused, "This study needs a gamepad. Please connect one and move its stick.")
        if running.study.group == 1:
            await running.form([session])
        else:
            await running.move(session, WAITING)
            await running.match()

    async def _ready(self, session: ParticipantSession, step: Step, done: bool) -> None:
        """Ready for a round or for practice, or through with practising."""
        running, unit = self._running, self._running.unit_of(session)
        if unit is None:
            return
        await running.rooms.write_down(unit)
        if unit.finished_round is not None or session.record.step != step.key:
            return  # the last one is not saved yet, or was this one
        if step.kind == "practice" and done:
            await self._practised(session, unit, step)
        elif unit.running_round is None or unit.running_round.step.key != step.key:
            unit.ready_at = unit.ready_at if unit.ready else running.now()
            unit.ready.add(session.pid)
            if unit.running_round is None and unit.all_ready(step):
                await running.rooms.open(unit, step)
        running.push(*unit.others(session))

    async def _practised(self, session: ParticipantSession, unit: StudyUnit, step: Step) -> None:
        """Enough practice for one; the other of a pair may play on alone."""
        running = self._running
        await running.advance(session)
        game = unit.running_round
        if game is None or game.step.key != step.key:
            return
        if unit.at(step):
            game.room.retire(game.room.seats[game.seats[session.pid]], running.now())
        else:
            running.rooms.close(unit, "The practice is over.")

    async def _debriefed(self, session: ParticipantSession, keep: bool | None) -> None:
        running = self._running
        if running.study.debrief is not None and running.study.debrief.ask_to_keep:
            if keep is None:
                raise StepRefused("keep", "Please say whether we may keep your data.")
            await running.run(running.databases.store.keep_data, session.pid, keep)
        await running.advance(session)
        if keep is False:
            running.remove_data(session)

    async def answer(self, session: ParticipantSession, request: StudyAnswerRequest) -> None:
        """Keep one request; also one that arrives when the page has gone on already. Raises AnswerError, StoreError."""
        running = self._running
        step = next((step for step in session.steps if step.key == request.key and step.questionnaire), None)
        if step is None or session.declined or (session.finished and session.record.keep is False):
            raise StepRefused("step", "This question is not asked (any more).")
        questionnaire = running.study.questionnaire(step.questionnaire, session.record.language)
        questionnaire.check_answer(request.item, request.value, request.text)
        elapsed_ms, hidden_ms = max(0.0, request.elapsed_ms), max(0.0, request.hidden_ms)
        await running.run(
            running.databases.store.answer, session.pid, step.key, step.questionnaire, step.partner, request.item,
            request.value, request.text, elapsed_ms, hidden_ms,
        )  # fmt: skip

    async def speak(self, session: ParticipantSession, language: str) -> None:
        """Another language from now on, where the study has it."""
        running = self._running
        if language in running.study.languages and language != session.record.language and not session.declined:
            async with running.lock:
                await running.run(running.databases.store.speak, session.pid, language)
                await running.refresh(session)

    async def decline(self, session: ParticipantSession) -> None:
        """No consent: nothing is kept but the number of those who declined."""
        running = self._running
        async with running.lock:
            if session.finished or session.record.step != session.steps[0].key:
                return
            await running.run(running.databases.store.decline, session.pid)
            await running.run(running.databases.identities.forget, session.pid)
            session.declined = True
            del running.sessions[session.pid]

    async def stop(self, session: ParticipantSession, keep: bool) -> None:
        """The participant stops, with or without the data. Asking again changes nothing."""
        async with self._running.lock:
            if session.record.step == session.steps[0].key and not session.finished:
                keep = False  # without consent there is nothing that could be kept
            refused = session.refused and session.record.step == LAST_ALONE
            await self._running.dismiss(session, "screened-out" if refused else "withdrew", keep)
