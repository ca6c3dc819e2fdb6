"""A simulated participant: completes every step that the server shows, and logs what it did and was shown."""

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from random import Random
from typing import Any, NamedTuple

from movingout.recordings.episode import FINISHED
from movingout.server.study_bots.answer_model import AnswerModel
from movingout.server.study_bots.faults import FaultInjection
from movingout.server.study_bots.policies import SeatPolicy
from movingout.server.study_bots.seat_client import SeatClient
from movingout.server.study_bots.study_client import RequestRefused, StudyClient, View

REFRESH_S = 2.0  # how often the view is requested without an event
READING_S = (0.5, 2.0)  # time on each screen
PRACTICE_TICKS = (30, 100)  # of practice before going on
RTT_MS = (8.0, 60.0)


class SavedAnswer(NamedTuple):
    """An answer that the server has confirmed."""

    step: str
    item: str
    value: int
    text: str


@dataclass
class ActivityLog:
    """What must be found in the study's data afterwards."""

    name: str
    saved_answers: list[SavedAnswer] = field(default_factory=list)
    codes: set[str] = field(default_factory=set)
    outcome: str = ""
    rounds: set[str] = field(default_factory=set)  # keys of the rounds that were played to their end
    deleted: bool = False  # the participant asked for the data to be deleted
    done: int = 0  # steps
    total: int = 0


class SimulatedParticipant:
    """One participant, who reads `speed` times as fast as people."""

    def __init__(
        self,
        name: str,
        client: StudyClient,
        address: str,
        policy: SeatPolicy,
        faults: FaultInjection,
        random: Random,
        speed: float,
    ) -> None:
        self.log = ActivityLog(name)
        self._client = client
        self._address = address
        self._policy = policy
        self._faults = faults
        self._random = random
        self._speed = speed
        self._answer_model = AnswerModel(random)
        self._device = random.choice(("keyboard", "gamepad"))
        self._changed = asyncio.Event()

    async def take_part(self, languages: list[str]) -> ActivityLog:
        """Go from the link to the completion code, and return the log."""
        language = self._random.choice(languages)
        view = await self._client.arrive({"PROLIFIC_PID": self.log.name, "STUDY_ID": "simulated"}, language)
        listening = asyncio.create_task(self._listen())
        try:
            while view["step"]["kind"] != "code":
                self.log.done, self.log.total = view["position"]["done"], view["position"]["total"]
                view = await self._take_step(view)
        finally:
            listening.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await listening
        return self._finish(view)

    def _finish(self, view: View) -> ActivityLog:
        step = view["step"]
        self.log.codes.add(str(step["code"]))
        self.log.outcome = step["outcome"]
        self.log.deleted = self.log.deleted or step.get("kept") is False
        self.log.done = self.log.total
        return self.log

    async def _listen(self) -> None:
        async for _ in self._client.events():
            self._changed.set()

    async def _take_step(self, view: View) -> View:
        await asyncio.sleep(self._random.uniform(*READING_S) / self._speed + self._faults.absence_s())
        if self._faults.happens(self._faults.leaves) and view["can_stop"]:
            return await self._leave()
        if self._faults.happens(self._faults.reloads):
            return await self._client.view()
        try:
            return await self._complete(view["step"])
        except RequestRefused as refusal:
            if refusal.status in (401, 404):
                raise
            return await self._client.view()  # the step has changed: the partner left, or the experimenter paused

    async def _leave(self) -> View:
        keep = self._random.random() < 0.5
        self.log.deleted = not keep
        return await self._client.stop(keep)

    async def _complete(self, step: dict[str, Any]) -> View:
        screens: dict[str, Callable[[dict[str, Any]], Awaitable[View]]] = {
            "consent": self._consent,
            "form": self._answer_questions,
            "questionnaire": self._answer_questions,
            "input-check": self._check_input,
            "practice": self._play,
            "round": self._play,
            "break": self._continue,
            "debrief": self._complete_debrief,
        }
        return await screens.get(step["kind"], self._wait)(step)

    async def _next(self, key: str, **said: object) -> View:
        if self._faults.happens(self._faults.twice):
            await self._client.next(key, **said)
        return await self._client.next(key, **said)

    async def _continue(self, step: dict[str, Any]) -> View:
        return await self._next(step["key"])

    async def _wait(self, step: dict[str, Any]) -> View:
        """For an event, but not longer than REFRESH_S."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(REFRESH_S):
                await self._changed.wait()
        self._changed.clear()
        return await self._client.view()

    async def _consent(self, step: dict[str, Any]) -> View:
        boxes = [box["id"] for box in step["boxes"] if box["required"] or self._random.random() < 0.7]
        return await self._next(step["key"], boxes=boxes)

    async def _answer_questions(self, step: dict[str, Any]) -> View:
        """Answer the questions that are still open."""
        known = step.get("answers", {})
        for item in step["items"]:
            if item["id"] in known:
                continue
            value, text = self._answer_model.answer(item, step.get("partner_letter") or "")
            elapsed_ms = self._random.uniform(800, 6000)
            await self._client.answer(step["key"], item["id"], value, text, elapsed_ms)
            self.log.saved_answers.append(SavedAnswer(step["key"], item["id"], value, text))
            if self._faults.happens(self._faults.reloads):
                return await self._client.view()
        return await self._next(step["key"])

    async def _check_input(self, step: dict[str, Any]) -> View:
        device = "gamepad" if step["gamepad_required"] else self._device
        return await self._next(step["key"], rtt_ms=round(self._random.uniform(*RTT_MS), 1), device=device)

    async def _complete_debrief(self, step: dict[str, Any]) -> View:
        return await self._next(step["key"], **({"keep": True} if step["ask_to_keep"] else {}))

    async def _play(self, step: dict[str, Any]) -> View:
        state, room = step["state"], step["room"]
        if state == "waiting" or (state == "playing" and room is None):
            return await self._wait(step)
        if state != "playing":
            return await self._next(step["key"])
        practice = step["kind"] == "practice"
        player = SeatClient(
            self._address, room=room["id"], token=room["token"], policy=self._policy, device=self._device
        )
        max_ticks = self._random.randint(*PRACTICE_TICKS) if practice else 0
        over = await player.play(lambda: self._faults.happens(self._faults.drops), max_ticks)
        if player.left_early:
            return await self._next(step["key"], done=True)
        if player.outcome in FINISHED and not practice:
            self.log.rounds.add(step["key"])
        return await self._wait(step) if over else await self._client.view()
