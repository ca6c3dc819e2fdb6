"""The benchmarks measure what they say: the same states, and only known names."""

from dataclasses import astuple

import numpy as np
import pytest

from bench import agents, diversity, learning
from bench.__main__ import main
from bench.world import EngineTimedWorld, driving
from movingout.maps import load_map
from movingout.world import World


def test_an_unknown_benchmark_is_answered_with_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["wrold"]) == 2
    assert "unknown benchmark 'wrold'; did you mean world? known: " in capsys.readouterr().err


def test_a_benchmark_with_options_takes_its_own_ones_alone(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["diversity", "--maps", "SingleRotation", "--people", "4", "--ticks", "3", "--workers", "1"]
    assert main(words) == 0
    assert "| paper: Expert dataset |" in capsys.readouterr().out


def test_the_words_of_the_command_are_not_taken_for_options(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[list[str]] = []
    monkeypatch.setattr("sys.argv", ["bench", "diversity", "learning"])
    for module in (diversity, learning):
        monkeypatch.setattr(module, "main", given.append)
    assert main(["diversity", "learning"]) == 0
    assert given == [[], []]


@pytest.mark.parametrize("words", [["--people", "4"], ["world", "--people", "4"], ["diversity", "bass", "--help"]])
def test_options_that_nobody_takes_are_refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    assert "put options after the one benchmark they are for" in capsys.readouterr().err


def test_the_engine_is_timed_over_the_same_states_as_the_world() -> None:
    plain, timed = World(load_map("LeftRight")), EngineTimedWorld(load_map("LeftRight"), record_sub_poses=False)
    for actions in driving(seed=7)[:200]:
        plain.step(actions)
        timed.step(actions)
    for here, there in zip(astuple(plain.state()), astuple(timed.state()), strict=True):
        assert np.array_equal(here, there)
    assert timed.engine_seconds > 0


def test_a_decision_of_an_agent_is_timed_and_its_share_of_a_core_is_that_of_all_its_decisions() -> None:
    found = agents.cost("scripted", ("HandOff",), 20)
    assert 0.0 < found.core_share < 1.0 and found.first_mb > 10.0
    assert found.core_share == pytest.approx(found.decisions_per_s * found.decision_ms / 1e3)
