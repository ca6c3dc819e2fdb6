"""Alerts for the experimenter: a code and values for the page, a sentence in English for logs and programs."""

import logging
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from movingout.server.notices import AlertCode

log = logging.getLogger(__name__)

MAX_ALERTS = 100  # older ones are dropped
MOST_ALIKE = 25  # with one code, so that many of one kind hide no other
REPEAT_S = 60.0  # the same alert is not added again within this time


@dataclass(frozen=True, slots=True)
class Alert:
    """One alert; `about` is its code. `detail` is technical, for whoever runs the server, and not translated."""

    id: int
    at: float  # wall clock, seconds since the epoch
    about: AlertCode
    text: str  # in English, with the detail
    values: dict[str, Any]
    detail: str


class Alerts:
    """The newest alerts, of each code so many. May be used from any thread."""

    def __init__(self, now: Callable[[], float] = time.time) -> None:
        self._now = now
        self._alerts: list[Alert] = []
        self.counts: Counter[AlertCode] = Counter()  # of each code, older ones included

    def add(self, about: AlertCode, text: str, /, detail: str = "", **values: Any) -> bool:
        """Add an alert, and log it: returns whether it is new. `text` is in English and says the same as `values`.

        The same text and values again are ignored for a minute, whatever the detail: it may hold a figure that changes.
        """
        now = self._now()
        detail = detail.encode(errors="backslashreplace").decode()  # a file's name may be no UTF-8, which JSON refuses
        recent = [one for one in self._alerts if one.about == about and 0.0 <= now - one.at < REPEAT_S]
        if any(one.values == values and one.text == _with_detail(text, one.detail) for one in recent):
            return False
        text = _with_detail(text, detail)
        log.warning(f"alert {about}: %s", text)  # a template each: what strangers cause leaves out no other
        self.counts[about] += 1
        alike = [one for one in self._alerts if one.about == about]
        kept = [one for one in self._alerts if len(alike) < MOST_ALIKE or one is not alike[0]]
        self._alerts = [*kept, Alert(self.number, now, about, text, values, detail)][-MAX_ALERTS:]
        return True

    def settle(self, about: AlertCode, /, **values: Any) -> None:
        """Show those with these values no more: what they say is over. They still count, and are in the log."""
        self._alerts = [one for one in self._alerts if (one.about, one.values) != (about, values)]

    @property
    def number(self) -> int:
        """How many there have been, older ones included."""
        return self.counts.total()

    def to_json(self) -> list[dict[str, Any]]:
        """The newest first."""
        return [asdict(one) for one in reversed(self._alerts)]


def _with_detail(text: str, detail: str) -> str:
    return f"{text} ({detail})" if detail else text
