"""A participant as the running server knows them.

Everything that must not be lost is in the store; this is what can be made again from it, and who is present now.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from movingout.study.design.step_order import LAST_ALONE, WAITING
from movingout.study.design.steps import Step
from movingout.study.store.store import Participant

PRESENT_S = 25.0  # the page asks every 10 s
HIDDEN_S = 75.0  # a hidden tab asks once a minute, while its stream stays open
Push = Callable[[dict[str, Any]], None]


@dataclass(eq=False)
class Guest:
    """One participant."""

    place: Participant
    way: tuple[Step, ...]
    heard_at: float  # seconds of the server's clock
    since: float  # when the current step was reached
    source: str = ""
    rtt_ms: float = -1.0
    device: str = ""
    refused: str = ""  # why the input check was not passed
    declined: bool = False
    pushes: list[Push] = field(default_factory=list)  # to the pages that are open

    @property
    def pid(self) -> str:
        return self.place.pid

    @property
    def finished(self) -> bool:
        return self.declined or self.place.code is not None

    @property
    def step(self) -> Step | None:
        """The current step; None in the waiting room."""
        return next((step for step in self.way if step.key == self.place.step), None)

    @property
    def on_the_way(self) -> bool:
        """Whether they have not come to the first step of their unit yet."""
        return self.place.step in (LAST_ALONE, WAITING) and not self.finished

    def done(self) -> int:
        """How many steps are done."""
        if self.finished:
            return len(self.way)
        keys = [step.key for step in self.way]
        return keys.index(LAST_ALONE) + 1 if self.place.step == WAITING else keys.index(self.place.step)

    def plays_on(self) -> bool:
        """Whether rounds are still to come."""
        return any(step.kind in ("practice", "round") for step in self.way[self.done() :])

    def present(self, now: float) -> bool:
        """Whether a page of theirs is open; also one that sleeps behind another tab."""
        return now - self.heard_at < (HIDDEN_S if self.pushes else PRESENT_S)
