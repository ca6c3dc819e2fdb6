"""The benchmarks measure what they say: the same states, and only known names."""

from dataclasses import astuple

import numpy as np
import pytest

from bench.__main__ import main
from bench.world import EngineTimedWorld, driving
from maps import load_map
from world import World


def test_an_unknown_benchmark_is_answered_with_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["wrold"]) == 2
    assert "unknown benchmark 'wrold'; known: " in capsys.readouterr().err


def test_the_engine_is_timed_over_the_same_states_as_the_world() -> None:
    plain, timed = World(load_map("LeftRight")), EngineTimedWorld(load_map("LeftRight"), record_sub_poses=False)
    for actions in driving(seed=7)[:200]:
        plain.step(actions)
        timed.step(actions)
    for here, there in zip(astuple(plain.state()), astuple(timed.state()), strict=True):
        assert np.array_equal(here, there)
    assert timed.engine_seconds > 0
