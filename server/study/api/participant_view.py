"""What a participant's page is sent: the current step, and nothing that reveals who the partner is."""

import time
from typing import Any

from movingout.maps import TUTORIAL, map_to_json
from movingout.server.study.arrivals.arrival_link import PLATFORMS, PROLIFIC
from movingout.server.study.earnings import earnings
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.unit import StudyUnit
from movingout.study.design.allocation import letters
from movingout.study.design.consent_text import filled
from movingout.study.design.definition import Outcome
from movingout.study.design.markdown import html
from movingout.study.design.steps import BREAK_S, Step
from movingout.study.store.store import GivenAnswer
from movingout.world.constants import TICK_SECONDS

View = dict[str, Any]
PROLIFIC_ADDRESS = "https://app.prolific.com/submissions/complete?cc="
LONG_AGO_S = 900.0  # who opens the page so long after the end may be the next person at that machine
AGENT_IN_PAIRS = "A"  # the letter of the agent that replaces a partner who never came


class ParticipantViews:
    """The views of all participants of a study."""

    def __init__(self, running: RunningStudy) -> None:
        self._running = running
        self._letters = {name: shown.removeprefix("Partner ") for name, shown in letters(running.study).items()}

    async def view(self, session: ParticipantSession) -> View:
        """The whole view. Raises StoreError."""
        step = await self._step(session)
        can_stop = session.has_consented and not session.finished  # before, the page can be closed
        return self._frame(session.record.language, step, session.steps_done(), len(session.steps), can_stop)

    def elsewhere(self) -> View:
        """For a page that was superseded by another one: nobody's, so it has no place, and keeps its own language."""
        language = self._running.study.languages[0]
        return self._frame(language, {"key": "elsewhere", "kind": "ended-elsewhere"}, 0, 0, False)

    def letter(self, unit: StudyUnit | None, step: Step) -> str | None:
        """The letter of the partner; None for another person, and in practice."""
        if step.kind == "practice" or unit is None:
            return None
        substitute = self._running.study.group == 2 and unit.size == 1 and step.block
        return AGENT_IN_PAIRS if substitute else self._letters.get(step.partner)

    def _frame(self, language: str, step: View, done: int, total: int, can_stop: bool) -> View:
        study = self._running.study
        return {
            "study": {"title": study.title.text(language)},
            "language": language,
            "languages": list(study.languages),
            "step": step,
            "position": {"done": done, "total": total},
            "can_stop": can_stop,
        }

    async def _step(self, session: ParticipantSession) -> View:
        step, running = session.step, self._running
        if session.finished:
            return self._code(session)
        if running.progress.is_paused(session):
            return {"key": "paused", "kind": "paused"}
        if step is None:
            return self._waiting(session)
        shown: View = {"key": step.key, "kind": step.kind}
        if step.kind == "consent":
            return shown | self._consent(session.record.language)
        if step.questionnaire:
            return shown | await self._questions(session, step)
        if step.kind == "input-check":
            gate = running.study.gate
            return shown | {"gamepad_required": gate.gamepad, "rtt_ms": gate.rtt_ms}
        if step.kind in ("practice", "round"):
            return shown | await self._round(session, step)
        if step.kind == "debrief" and running.study.debrief is not None:
            told = self._debriefing(session.record.language)
            return shown | {"html": told, "ask_to_keep": running.study.debrief.ask_to_keep}
        return shown | {"seconds": BREAK_S}

    def _debriefing(self, language: str) -> str | None:
        debrief = self._running.study.debrief
        return html(filled(self._running.study, debrief.text, language)) if debrief else None

    def _consent(self, language: str) -> View:
        study, consent = self._running.study, self._running.study.consent
        boxes = [
            {"id": box.id, "text": filled(study, box.text, language), "required": box.required} for box in consent.boxes
        ]
        return {"version": consent.version, "html": html(filled(study, consent.text, language)), "boxes": boxes}

    async def _questions(self, session: ParticipantSession, step: Step) -> View:
        running, study = self._running, self._running.study
        questionnaire = study.questionnaire(step.questionnaire, session.record.language)
        if study.shuffles(step.questionnaire):
            questionnaire = questionnaire.shuffled(f"{session.pid} {step.key}")
        given = await running.databases.run(running.databases.store.answers, session.pid, step.key)
        return {
            "title": questionnaire.title,
            "items": [item.as_json() for item in questionnaire.items],
            "answers": {item: _shown_answer(one, session.texts_since_ms) for item, one in given.items()},
            "partner_letter": self.letter(running.units.of(session), step) if step.partner else None,
        }

    async def _round(self, session: ParticipantSession, step: Step) -> View:
        running, unit = self._running, self._running.units.of(session)
        await running.rooms.prepare(step)
        the_map = running.rooms.map_of(step)
        rounds = [one.key for one in session.steps if one.kind == "round"]
        number = {"number": rounds.index(step.key) + 1, "of": len(rounds)} if step.kind == "round" else {}
        own = running.study.map_text(running.rooms.map_name(step), session.record.language)
        title, description = own or (the_map.title, the_map.description)
        return number | {
            "map": map_to_json(the_map),
            "map_named": own is not None,
            "title": title,
            "description": description,
            "seat": unit.seat_of(step, session) if unit else 0,
            "partner_letter": self.letter(unit, step),
            "limit_s": step.limit_ticks * TICK_SECONDS,
            "sounds": running.study.sounds == "on",
            "tutorial": the_map.name == TUTORIAL and step.kind == "practice",
            **_state(session, unit, step),
        }

    def _waiting(self, session: ParticipantSession) -> View:
        running, pairing = self._running, self._running.study.pairing
        since = running.units.waiting_since(session)
        return {
            "key": "waiting",
            "kind": "waiting",
            "since_s": round(time.monotonic() - since, 1) if since is not None else 0.0,
            "wait_s": pairing.wait_s,
            "people": running.units.waiting_count,
            "otherwise": pairing.otherwise,
        }

    def _code(self, session: ParticipantSession) -> View:
        record, debrief = session.record, self._running.study.debrief
        outcome: Outcome | str | None = "declined" if session.declined else record.outcome
        ended_early = record.unit is not None and outcome != "done"  # after the game had begun, before the debriefing
        from_prolific = session.source == PROLIFIC and record.code
        return {
            "key": "code",
            "kind": "code",
            "code": record.code,
            "shared_code": self._running.study.shares(record.code),
            "long_ago": _long_ago(session),
            "outcome": outcome,
            "completion_url": f"{PROLIFIC_ADDRESS}{record.code}" if from_prolific else None,
            "from_platform": session.source in PLATFORMS,
            "earned": earnings(self._running.study, session.record),
            "kept": record.keep,
            "html": self._debriefing(record.language) if ended_early else None,
            "ask_to_keep": ended_early and debrief is not None and debrief.ask_to_keep,
        }


def _long_ago(session: ParticipantSession) -> bool:
    """Whether the page may be opened by the next person; who was ended while away has their code before them."""
    finished_ms = session.record.finished_ms
    if finished_ms is None or (session.ended_at and time.monotonic() - session.ended_at <= LONG_AGO_S):
        return False
    return time.time() - finished_ms / 1e3 > LONG_AGO_S


def _shown_answer(given: GivenAnswer, since_ms: int) -> View:
    hidden = bool(given.text) and given.at_ms < since_ms
    shown: View = {"value": given.value, "text": "" if hidden else given.text}
    return shown | ({"hidden": True} if hidden else {})


def _state(session: ParticipantSession, unit: StudyUnit | None, step: Step) -> View:
    """The state of a round for one participant, and the address of its room."""
    if unit is None:
        return {"state": "card", "room": None}
    if unit.finished_round is not None and unit.finished_round.step.key == step.key:
        return {"state": "over", "room": None}
    running_round = unit.running_round
    if running_round is not None and running_round.step.key == step.key and session.pid in running_round.keys:
        room = {
            "id": running_round.room,
            "token": running_round.keys[session.pid],
            "seat": running_round.seats[session.pid],
        }
        return {"state": "playing", "room": {**room, "path": f"/play/{running_round.room}"}}
    return {"state": "waiting" if session.pid in unit.ready else "card", "room": None}
