"""Alerts for the experimenter."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

MAX_ALERTS = 100  # older ones are dropped
REPEAT_S = 60.0  # the same alert is not added again within this time


@dataclass(frozen=True, slots=True)
class Alert:
    """One alert; `about` is its kind."""

    id: int
    at: float  # wall clock, seconds since the epoch
    about: str
    text: str


class Alerts:
    """The newest alerts. May be used from any thread."""

    def __init__(self, now: Callable[[], float] = time.time) -> None:
        self._now = now
        self._alerts: list[Alert] = []
        self._number = 0

    def add(self, about: str, text: str) -> None:
        now = self._now()
        if any(one.about == about and one.text == text and now - one.at < REPEAT_S for one in self._alerts):
            return
        self._number += 1
        self._alerts = [*self._alerts, Alert(self._number, now, about, text)][-MAX_ALERTS:]

    def to_json(self) -> list[dict[str, Any]]:
        """The newest first."""
        return [asdict(one) for one in reversed(self._alerts)]
