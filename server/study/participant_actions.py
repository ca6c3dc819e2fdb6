"""What each request of a participant does. Asking twice for the same is harmless everywhere."""

from collections.abc import Sequence

import msgspec

from movingout.server.study.participant_session import Guest
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.unit import Crew
from movingout.study.design.step_order import LAST_ALONE, WAITING
from movingout.study.design.steps import Step
from movingout.study.errors import StudyError

MOST_DEVICE = 16  # letters


class WrongAnswer(StudyError):
    """What a participant sent does not do; `code` is for the page."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


class Said(msgspec.Struct):
    """The body of POST /api/study/next: the step that is done, and what that step needs."""

    key: str
    boxes: list[str] = []
    rtt_ms: float = 0.0
    device: str = ""
    keep: bool | None = None
    done: bool = False  # practised enough


class Click(msgspec.Struct):
    """The body of POST /api/study/answer."""

    key: str
    item: str
    value: int
    text: str = ""
    elapsed_ms: float = 0.0
    hidden_ms: float = 0.0


class Journey:
    """The requests of all participants."""

    def __init__(self, running: RunningStudy) -> None:
        self._running = running

    async def go_on(self, guest: Guest, said: Said) -> None:
        """The participant has done the step `said.key`; a step that is over already is left alone."""
        running = self._running
        if guest.step is not None and said.key == guest.step.key:
            await running.playing.prepare(guest.step)
        async with running.lock:
            step = guest.step
            if guest.finished or step is None or said.key != step.key or running.stays(guest):
                return
            if step.kind == "consent":
                await self._consent(guest, said.boxes)
            elif step.kind == "input-check":
                await self._check_input(guest, said.rtt_ms, said.device)
            elif step.kind in ("practice", "round"):
                await self._ready(guest, step, said.done)
            elif step.kind == "debrief":
                await self._debriefed(guest, said.keep)
            else:
                await running.advance(guest)

    async def _consent(self, guest: Guest, boxes: Sequence[str]) -> None:
        running, consent = self._running, self._running.study.consent
        if any(box.required and box.id not in boxes for box in consent.boxes):
            raise WrongAnswer("boxes", "Please tick the boxes that are required, or say that you do not agree.")
        language = guest.place.language
        ticked = [box.id for box in consent.boxes if box.id in boxes]
        shown = consent.text.text(language)
        if not await running.run(running.records.store.has_consented, guest.pid, consent.version):
            await running.run(running.records.store.consent, guest.pid, consent.version, language, shown, ticked)
        await running.advance(guest)

    async def _check_input(self, guest: Guest, rtt_ms: float, device: str) -> None:
        running, gate = self._running, self._running.study.gate
        guest.rtt_ms, guest.device, guest.refused = rtt_ms, device[:MOST_DEVICE], ""
        if rtt_ms > gate.rtt_ms:
            guest.refused = "slow"
            most = f"{rtt_ms:.0f} ms, at most {gate.rtt_ms}"
            raise WrongAnswer(guest.refused, f"This connection is too slow for the game: {most}.")
        if gate.gamepad and device != "gamepad":
            guest.refused = "gamepad"
            raise WrongAnswer(guest.refused, "This study needs a gamepad. Please connect one and move its stick.")
        if running.study.group == 1:
            await running.form([guest])
        else:
            await running.move(guest, WAITING)
            await running.match()

    async def _ready(self, guest: Guest, step: Step, done: bool) -> None:
        """Ready for a round or for practice, or through with practising."""
        running, crew = self._running, self._running.crew_of(guest)
        if crew is None:
            return
        await running.playing.write_down(crew)
        if crew.over is not None or guest.place.step != step.key:
            return  # the last one is not saved yet, or was this one
        if step.kind == "practice" and done:
            await self._practised(guest, crew, step)
        elif crew.game is None or crew.game.step.key != step.key:
            crew.ready_at = crew.ready_at if crew.ready else running.now()
            crew.ready.add(guest.pid)
            if crew.game is None and crew.all_ready(step):
                await running.playing.open(crew, step)
        running.push(*crew.others(guest))

    async def _practised(self, guest: Guest, crew: Crew, step: Step) -> None:
        """Enough practice for one; the other of a pair may play on alone."""
        running = self._running
        await running.advance(guest)
        game = crew.game
        if game is None or game.step.key != step.key:
            return
        if crew.at(step):
            game.room.retire(game.room.seats[game.seats[guest.pid]], running.now())
        else:
            running.playing.close(crew, "The practice is over.")

    async def _debriefed(self, guest: Guest, keep: bool | None) -> None:
        running = self._running
        if running.study.debrief is not None and running.study.debrief.ask_to_keep:
            if keep is None:
                raise WrongAnswer("keep", "Please say whether we may keep your data.")
            await running.run(running.records.store.keep_data, guest.pid, keep)
        await running.advance(guest)
        if keep is False:
            running.remove_data(guest)

    async def answer(self, guest: Guest, click: Click) -> None:
        """Keep one click; also one that arrives when the page has gone on already. Raises AnswerError, StoreError."""
        running = self._running
        step = next((step for step in guest.way if step.key == click.key and step.questionnaire), None)
        if step is None or guest.declined or (guest.finished and guest.place.keep is False):
            raise WrongAnswer("step", "This question is not asked (any more).")
        questionnaire = running.study.questionnaire(step.questionnaire, guest.place.language)
        questionnaire.check_answer(click.item, click.value, click.text)
        elapsed_ms, hidden_ms = max(0.0, click.elapsed_ms), max(0.0, click.hidden_ms)
        await running.run(
            running.records.store.answer, guest.pid, step.key, step.questionnaire, step.partner, click.item,
            click.value, click.text, elapsed_ms, hidden_ms,
        )  # fmt: skip

    async def speak(self, guest: Guest, language: str) -> None:
        """Another language from now on, where the study has it."""
        running = self._running
        if language in running.study.languages and language != guest.place.language and not guest.declined:
            async with running.lock:
                await running.run(running.records.store.speak, guest.pid, language)
                await running.refresh(guest)

    async def decline(self, guest: Guest) -> None:
        """No consent: nothing is kept but the number of those who declined."""
        running = self._running
        async with running.lock:
            if guest.finished or guest.place.step != guest.way[0].key:
                return
            await running.run(running.records.store.decline, guest.pid)
            await running.run(running.records.identities.forget, guest.pid)
            guest.declined = True
            del running.guests[guest.pid]

    async def stop(self, guest: Guest, keep: bool) -> None:
        """The participant stops, with or without the data. Asking again changes nothing."""
        async with self._running.lock:
            if guest.place.step == guest.way[0].key and not guest.finished:
                keep = False  # without consent there is nothing that could be kept
            refused = guest.refused and guest.place.step == LAST_ALONE
            await self._running.dismiss(guest, "screened-out" if refused else "withdrew", keep)
