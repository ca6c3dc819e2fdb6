"""How the decisions of an agent are timed: by a clock that the test steps."""

import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from movingout.agents import decision_time
from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.decision_time import DECISIONS, LEAST, SERIES, median_decision_s, unhindered
from movingout.agents.trial import decision_ms
from movingout.maps import load_map

MAP = load_map("HandOff")


class Stepping:
    """An agent, and the clock that its decisions let pass; `takes` are seconds, the last one again and again."""

    def __init__(self, *takes: float, reset_s: float = 100.0) -> None:
        self.takes, self.now, self.decided, self.reset_s = list(takes), 0.0, 0, reset_s

    def clock(self) -> float:
        return self.now

    def reset(self, episode: EpisodeInfo) -> None:
        self.now += self.reset_s  # not part of a decision

    def act(self, observation: Observation) -> ActionChunk:
        self.now += self.takes[min(self.decided, len(self.takes) - 1)]
        self.decided += 1
        return np.array([[0.0, 1.0, 0.0, 0.0]])


def median_ms(agent: Stepping) -> float:
    return round(1e3 * median_decision_s(agent, MAP, agent.clock))


def test_the_first_decision_and_a_busy_moment_do_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decision_time, "ENOUGH_S", 1e6)
    assert median_ms(Stepping(5.0, 0.02)) == 20
    assert median_ms(Stepping(5.0, *[0.3] * DECISIONS, 0.04)) == 40
    assert median_ms(Stepping(5.0, 0.3, 0.04, 0.04, 0.3, 0.04)) == 40


def test_an_agent_that_keeps_up_is_timed_once_and_a_slow_one_not_for_long(monkeypatch: pytest.MonkeyPatch) -> None:
    quick, slow = Stepping(0.02), Stepping(0.2)
    assert (median_ms(quick), quick.decided) == (20, 1 + DECISIONS)
    assert (median_ms(slow), slow.decided) == (200, 1 + LEAST * DECISIONS), "resetting it took minutes"
    monkeypatch.setattr(decision_time, "ENOUGH_S", 1e6)
    patient = Stepping(0.2)
    assert (median_ms(patient), patient.decided) == (200, 1 + SERIES * DECISIONS)


def test_an_agent_whose_first_decision_takes_long_has_as_many_series_as_others() -> None:
    heavy = Stepping(5.0, *[0.15] * 3 * DECISIONS, 0.04, reset_s=0.0)
    assert (median_ms(heavy), heavy.decided) == (40, 1 + 4 * DECISIONS)
    unhurried = Stepping(5.0, *[0.3] * DECISIONS, 0.04)
    assert (median_ms(unhurried), unhurried.decided) == (40, 1 + LEAST * DECISIONS), "a busy moment, and slow resets"


def test_waiting_for_a_busy_processor_is_no_cost_of_an_agent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    waited = tmp_path / "schedstat"
    monkeypatch.setattr(decision_time, "_WAITED", waited)
    monkeypatch.setattr(time, "perf_counter", lambda: 10.0)
    assert unhindered() == 10.0, "where the system does not tell it"
    waited.write_text("7000000000 2500000000 12\n")
    assert unhindered() == 7.5


@pytest.mark.parametrize("agent_id", ["idle", "ghost:none.mcap#red", "late:agent=idle", "llm:model=x,url=http://h/v1"])
def test_agents_that_no_tick_waits_for_are_not_timed(agent_id: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr("subprocess.run")
    assert decision_ms(agent_id, "HandOff") is None


@pytest.mark.parametrize("written", [b"", b"loaded the weights\n"])
def test_an_agent_that_ends_its_process_orderly_was_not_timed(written: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("subprocess.run", lambda command, **_: subprocess.CompletedProcess(command, 0, written))
    assert decision_ms("my_agent:Mine", "HandOff") is None


@pytest.mark.slow
def test_agents_are_timed_in_a_process_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("sleeping.py").write_text(
        "import time\n\n\nclass Agent:\n    def reset(self, episode):\n        print('reset')\n\n"
        "    def act(self, observation):\n        time.sleep(0.15)\n        return [[0.0, 1.0, 0.0, 0.0]]\n\n\n"
        "class Leaving(Agent):\n    def act(self, observation):\n        raise SystemExit\n"
    )
    needed = decision_ms("sleeping:Agent", "HandOff")
    assert needed is not None and 150 <= needed < 250
    for wrong in ("sleeping:Nobody", "sleeping:Leaving"):
        assert decision_ms(wrong, "HandOff") is None, "others say what is wrong"
