"""The time limit of decisions: which time counts."""

from types import SimpleNamespace

import pytest

from movingout.matches.execution import decision_timeout
from movingout.matches.execution.decision_timeout import DecisionTimeout, DecisionTimer

LIMIT_S = 10.0


class _Alarms:
    """Of a timer in whose call an alarm comes whenever the clock is moved."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = self.computed = 0.0
        clock = SimpleNamespace(monotonic=lambda: self.now, process_time=lambda: self.computed)
        monkeypatch.setattr(decision_timeout, "time", clock)
        self._timer = DecisionTimer(LIMIT_S)
        self._timer.start()

    def after(self, passed: float, computing: float = 0.0) -> None:
        self.now, self.computed = self.now + passed, self.computed + computing
        self._timer._check(0, None)


def test_a_command_that_was_stopped_meanwhile_is_no_fault_of_the_agent(monkeypatch: pytest.MonkeyPatch) -> None:
    """By Ctrl-Z, or by a cluster that suspends jobs: the matches that were being played counted as failed."""
    alarms = _Alarms(monkeypatch)
    alarms.after(0.5)
    alarms.after(1000.0)
    for _ in range(18):
        alarms.after(0.5)
    with pytest.raises(DecisionTimeout):
        for _ in range(3):
            alarms.after(0.5)


def test_code_that_lets_no_alarm_through_is_no_command_that_was_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DecisionTimeout):
        _Alarms(monkeypatch).after(LIMIT_S + 1, computing=LIMIT_S)
