"""What examples/train_robomimic.py puts in the place of `gym`: our environment as robomimic 0.3 asks for it."""

import importlib.util
import sys
from types import ModuleType

import numpy as np
import pytest

pytest.importorskip("pettingzoo", reason="the extra `env` is not installed")

from movingout.recordings.exports.robomimic import ENVIRONMENT
from tests.support import ROOT

STILL = [0.0, 1.0, 0.0, 0.0]


@pytest.fixture
def gym(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The module that a program imports as `gym` after the example."""
    monkeypatch.setitem(sys.modules, "gym", ModuleType("gym"))  # taken back afterwards
    spec = importlib.util.spec_from_file_location("train_robomimic", ROOT / "examples" / "train_robomimic.py")
    assert spec is not None and spec.loader is not None
    spec.loader.exec_module(importlib.util.module_from_spec(spec))
    return sys.modules["gym"]


def test_the_environment_of_an_export_is_made_and_stepped_as_by_the_old_gym(gym: ModuleType) -> None:
    env = gym.make(ENVIRONMENT, map="HandOff", partner="scripted", seat="blue", layout="map-v1", limit_ticks=3)
    first = env.reset()
    assert isinstance(first, np.ndarray) and first.shape == (169,)
    ends = []
    for _ in range(3):
        seen, reward, done, info = env.step(STILL)
        assert seen.shape == (169,) and np.isfinite(reward) and "score" in info
        ends.append(done)
    assert ends == [False, False, True]
    assert env.render(mode="rgb_array").shape[2] == 3
