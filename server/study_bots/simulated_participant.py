"""A simulated participant: follows the server from screen to screen, and keeps a log of what it did and was told."""

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from random import Random
from typing import Any, NamedTuple

from movingout.server.study_bots.answer_model import AnswerModel
from movingout.server.study_bots.browser import RequestRefused, StudyBrowser, View
from movingout.server.study_bots.faults import FaultInjection
from movingout.server.study_bots.policies import SeatPolicy
from movingout.server.study_bots.seat_client import SeatClient

LOOK_S = 2.0  # without news the view is asked for again
READING_S = (0.5, 2.0)  # before each screen is dealt with
PRACTICE_TICKS = (30, 100)  # are enough
RTT_MS = (8.0, 60.0)
PLAYED = ("delivered", "time")


class SavedAnswer(NamedTuple):
    """An answer of which the server has said that it is saved."""

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
    rounds: set[str] = field(default_factory=set)  # keys of the steps that were played to their end
    deleted: bool = False  # the data, at their own wish
    done: int = 0  # steps
    total: int = 0


class SimulatedParticipant:
    """One of them; `speed` is how much faster than people they read."""

    def __init__(
        self,
        name: str,
        browser: StudyBrowser,
        address: str,
        policy: SeatPolicy,
        faults: FaultInjection,
        random: Random,
        speed: float,
    ) -> None:
        self.log = ActivityLog(name)
        self._browser = browser
        self._address = address
        self._policy = policy
        self._faults = faults
        self._random = random
        self._speed = speed
        self._answer_model = AnswerModel(random)
        self._device = random.choice(("keyboard", "gamepad"))
        self._news = asyncio.Event()

    async def take_part(self, languages: list[str]) -> ActivityLog:
        """From the link to the completion code."""
        language = self._random.choice(languages)
        view = await self._browser.arrive({"PROLIFIC_PID": self.log.name, "STUDY_ID": "simulated"}, language)
        listening = asyncio.create_task(self._listen())
        try:
            while view["step"]["kind"] != "code":
                self.log.done, self.log.total = view["position"]["done"], view["position"]["total"]
                view = await self._with_faults(view)
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
        async for _ in self._browser.news():
            self._news.set()

    async def _with_faults(self, view: View) -> View:
        await asyncio.sleep(self._random.uniform(*READING_S) / self._speed + self._faults.absence_s())
        if self._faults.happens(self._faults.leaves):
            return await self._leave()
        if self._faults.happens(self._faults.reloads):
            return await self._browser.view()
        try:
            return await self._deal_with(view["step"])
        except RequestRefused as refusal:
            if refusal.status in (401, 404):
                raise
            return await self._browser.view()  # somebody else went on: the partner left, the experimenter paused

    async def _leave(self) -> View:
        keep = self._random.random() < 0.5
        self.log.deleted = not keep
        return await self._browser.stop(keep)

    async def _deal_with(self, step: dict[str, Any]) -> View:
        screens: dict[str, Callable[[dict[str, Any]], Awaitable[View]]] = {
            "consent": self._agree,
            "form": self._fill_in,
            "questionnaire": self._fill_in,
            "input-check": self._check,
            "practice": self._play,
            "round": self._play,
            "break": self._go_on,
            "debrief": self._debriefed,
        }
        return await screens.get(step["kind"], self._wait)(step)

    async def _next(self, key: str, **said: object) -> View:
        if self._faults.happens(self._faults.twice):
            await self._browser.next(key, **said)
        return await self._browser.next(key, **said)

    async def _go_on(self, step: dict[str, Any]) -> View:
        return await self._next(step["key"])

    async def _wait(self, step: dict[str, Any]) -> View:
        """For news, or not too long."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(LOOK_S):
                await self._news.wait()
        self._news.clear()
        return await self._browser.view()

    async def _agree(self, step: dict[str, Any]) -> View:
        boxes = [box["id"] for box in step["boxes"] if box["required"] or self._random.random() < 0.7]
        return await self._next(step["key"], boxes=boxes)

    async def _fill_in(self, step: dict[str, Any]) -> View:
        """Answer what was not answered before a reload."""
        known = step.get("answers", {})
        for item in step["items"]:
            if item["id"] in known:
                continue
            value, text = self._answer_model.answer(item, step.get("partner_letter") or "")
            elapsed_ms = self._random.uniform(800, 6000)
            await self._browser.answer(step["key"], item["id"], value, text, elapsed_ms)
            self.log.saved_answers.append(SavedAnswer(step["key"], item["id"], value, text))
            if self._faults.happens(self._faults.reloads):
                return await self._browser.view()
        return await self._next(step["key"])

    async def _check(self, step: dict[str, Any]) -> View:
        device = "gamepad" if step["gamepad_required"] else self._device
        return await self._next(step["key"], rtt_ms=round(self._random.uniform(*RTT_MS), 1), device=device)

    async def _debriefed(self, step: dict[str, Any]) -> View:
        return await self._next(step["key"], **({"keep": True} if step["ask_to_keep"] else {}))

    async def _play(self, step: dict[str, Any]) -> View:
        state, room = step["state"], step["room"]
        if state == "waiting" or (state == "playing" and room is None):
            return await self._wait(step)
        if state != "playing":
            return await self._next(step["key"])
        practice = step["kind"] == "practice"
        player = SeatClient(self._address, room["id"], room["token"], self._policy, self._device)
        enough = self._random.randint(*PRACTICE_TICKS) if practice else 0
        over = await player.play(lambda: self._faults.happens(self._faults.drops), enough)
        if player.had_enough:
            return await self._next(step["key"], done=True)
        if player.outcome in PLAYED and not practice:
            self.log.rounds.add(step["key"])
        return await self._wait(step) if over else await self._browser.view()
