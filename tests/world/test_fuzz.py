"""Wild actions: whatever is sent to the world, no state with a NaN leaves it."""

import numpy as np
import numpy.typing as npt
import pytest

from movingout.maps import load_map, map_names
from movingout.world import World, WorldError

EPISODE_TICKS = 400
ALL_MAPS = (*map_names(), "Simple")


def wild_actions(generator: np.random.Generator, ticks: int) -> npt.NDArray[np.float64]:
    """(ticks, 2, 3): distances from playable to absurd, any heading, frequent grasps."""
    exponent = generator.choice([0.0, 0.0, 0.5, 2.0, 6.0, 100.0, 300.0], p=[0.3, 0.3, 0.2, 0.1, 0.05, 0.03, 0.02])
    distances = generator.uniform(-1, 1, (ticks, 2)) * 10.0 ** generator.uniform(0, exponent, (ticks, 2))
    headings = generator.uniform(-1, 1, (ticks, 2)) * generator.choice([4.0, 1e3, 1e15])
    distances[generator.random((ticks, 2)) < 0.2] = 0.0
    grasps = generator.random((ticks, 2)) < generator.uniform(0.05, 0.6)
    return np.stack([distances, headings, grasps], axis=2)


def fuzz(map_name: str, seed: int, ticks: int) -> int:
    """Play wild episodes and check every state; the number of episodes that ended in a WorldError."""
    generator, failures, played = np.random.default_rng(seed), 0, 0
    while played < ticks:
        world = World(load_map(map_name), record_sub_poses=False)
        for actions in wild_actions(generator, EPISODE_TICKS):
            played += 1
            try:
                world.step(actions)
            except WorldError:
                failures += 1
                break
            finally:
                state = world.state()
                assert np.isfinite(state.robot_poses).all()
                assert np.isfinite(state.robot_velocities).all()
                assert np.isfinite(state.item_poses).all()
    return failures


@pytest.mark.parametrize("map_name", ALL_MAPS)
def test_wild_actions_never_let_a_nan_out(map_name: str) -> None:
    fuzz(map_name, seed=1, ticks=EPISODE_TICKS)


@pytest.mark.slow
@pytest.mark.parametrize("map_name", ALL_MAPS)
def test_a_million_wild_steps_never_let_a_nan_out(map_name: str) -> None:
    fuzz(map_name, seed=2, ticks=1_000_000 // len(ALL_MAPS))
