from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from movingout.world.official_reward import OfficialDenseReward
from tests.support import reference
from tests.world.states import OFFICIAL_FILES, official_arrays, official_states


def test_the_recorded_rewards_are_there() -> None:
    assert reference("golden").is_dir()


@pytest.mark.parametrize("path", OFFICIAL_FILES, ids=lambda path: path.stem)
def test_official_dense_reward_equals_the_recorded_one(path: Path) -> None:
    map_spec, states = official_states(path)
    reward = OfficialDenseReward(map_spec)
    rewards = [reward(before, after) for before, after in pairwise(states)]
    np.testing.assert_allclose(rewards, official_arrays(path)["reward_dense"].astype(np.float64), rtol=0, atol=1e-9)
