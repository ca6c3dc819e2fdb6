"""The benchmarks measure what they say: the same states, and only known names."""

import importlib
import inspect
from dataclasses import astuple
from functools import partial

import numpy as np
import pytest

from bench import agents, crowd, diversity, learning
from bench.__main__ import MINUTES, main
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


def _noted(ran: list[tuple[str, list[str]]], name: str, options: list[str]) -> None:
    ran.append((name, options))


def _noted_alone(ran: list[tuple[str, list[str]]], name: str) -> None:
    ran.append((name, []))


def test_without_a_name_each_of_the_short_ones_runs_with_its_options(monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[tuple[str, list[str]]] = []
    for name in MINUTES:
        module = importlib.import_module(f"bench.{name}")
        takes_options = bool(inspect.signature(module.main).parameters)
        monkeypatch.setattr(module, "main", partial(_noted if takes_options else _noted_alone, ran, name))
    assert main([]) == 0
    assert ran == [(name, [*options]) for name, options in MINUTES.items()]
    assert {"attacks", "soak", "crowd", "answers"} <= MINUTES.keys()


def test_a_crowd_without_postgresql_is_said_and_stops_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def missing() -> None:
        pytest.skip("PostgreSQL is not on this machine")

    monkeypatch.setattr(crowd, "postgres_server", missing)
    crowd.main([])
    assert "not measured: PostgreSQL is not on this machine" in capsys.readouterr().out


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
