"""Which windows policies learn from."""

from pathlib import Path

import numpy as np
import pytest

from movingout.agents.data.dataset import SeatSamples, windows_of
from movingout.agents.errors import DataError
from movingout.agents.kinds.policy import build_policy
from movingout.agents.policies.config import PolicyConfig
from movingout.agents.policies.training import SOON, hand_changes, train_policy


def test_windows_before_a_hand_changes_are_found_and_those_that_begin_with_the_press() -> None:
    features, targets = np.zeros((12, 121), np.float32), np.full((12, 5), -1.0, np.float32)
    holds = np.arange(12) >= 7  # the hand closes in tick 6, which is wanted from then on
    features[:, 4] = np.where(holds, 1.0, -1.0)
    targets[6:, 4] = 1.0
    whole = windows_of([SeatSamples("p", features, targets)])
    assert np.flatnonzero(hand_changes(whole, np.arange(12))).tolist() == list(range(7 - SOON, 7))
    pressing = windows_of([SeatSamples("p", features[6:], targets[6:])])  # an expert who takes over and presses at once
    assert np.flatnonzero(hand_changes(pressing, np.arange(6))).tolist() == [0]


def test_events_are_of_levels_only(tmp_path: Path) -> None:
    windows = windows_of([SeatSamples("p", np.zeros((4, 121), np.float32), np.zeros((4, 5), np.float32))])
    config = PolicyConfig(layout="official-v1", width=8, depth=1, updates=1, grasp="toggle", event_weight=2)
    with pytest.raises(DataError, match="--grasp hold"):
        train_policy(build_policy, config.spec("mlp"), config, windows, tmp_path)
