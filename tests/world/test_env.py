import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pettingzoo", reason="the extra `env` is not installed")

from pettingzoo.test import parallel_api_test, parallel_seed_test

from movingout.maps import Rect, load_map
from movingout.world import ActionError, World, WorldError
from movingout.world.action import to_world
from movingout.world.env import REWARDS, MovingOutEnv
from movingout.world.metrics import METRICS
from movingout.world.observation import LAYOUTS, encode_state

STILL = np.array([0.0, 1.0, 0.0, 0.0], np.float32)
SCORED_LAST = {"score", *(metric.key for metric in METRICS)}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("split", [None, "train"])
def test_pettingzoos_own_api_test_passes(layout: str, split: Any) -> None:
    parallel_api_test(MovingOutEnv("CornerDecision", layout=layout, split=split, limit_ticks=40), num_cycles=100)


@pytest.mark.parametrize("split", [None, "train", "evaluation"])
def test_pettingzoos_own_seed_test_passes(split: Any) -> None:
    parallel_seed_test(lambda: MovingOutEnv("TopBottomPriority", split=split, limit_ticks=20), num_cycles=50)


def test_the_env_is_the_world() -> None:
    env, world = MovingOutEnv("LeftRight"), World(load_map("LeftRight"))
    observations, _ = env.reset(seed=1)
    generator = np.random.default_rng(4)
    for _ in range(20):
        actions = generator.uniform(-1, 1, (2, 4)).astype(np.float32)
        observations, *_ = env.step({"blue": actions[0], "red": actions[1]})
        world.step(to_world(actions))
        for seat, agent in enumerate(("blue", "red")):
            expected = encode_state(world.map, world.state(), seat).astype(np.float32)
            np.testing.assert_array_equal(observations[agent], expected)


def test_seeds_decide_the_variant_and_the_episodes_after_it_differ() -> None:
    def starts(seed: int) -> list[bytes]:
        env = MovingOutEnv("HandOff", split="train")
        first, _ = env.reset(seed=seed)
        second, _ = env.reset()
        return [first["blue"].tobytes(), second["blue"].tobytes()]

    assert starts(3) == starts(3)
    assert len({*starts(3), *starts(4)}) == 4


def test_an_episode_is_truncated_at_its_limit_with_the_metrics() -> None:
    env = MovingOutEnv("HandOff", limit_ticks=3)
    env.reset()
    for tick in (1, 2, 3):
        _, _, terminated, truncated, infos = env.step({"blue": STILL, "red": STILL})
        assert terminated == {"blue": False, "red": False}
        assert truncated == dict.fromkeys(("blue", "red"), tick == 3)
        assert set(infos["red"]) == (SCORED_LAST if tick == 3 else {"score"})
    assert env.agents == []
    with pytest.raises(WorldError, match=r"call reset\(\) first"):
        env.step({"blue": STILL, "red": STILL})


def test_an_episode_terminates_when_everything_is_delivered() -> None:

    everywhere = replace(load_map("Simple"), goals=(Rect(-1.2, -1.2, 1.2, 1.2),))
    env = MovingOutEnv(everywhere)
    env.reset()
    _, _, terminated, truncated, infos = env.step({"blue": STILL, "red": STILL})
    assert terminated == {"blue": True, "red": True}
    assert truncated == {"blue": False, "red": False}
    assert infos["blue"]["tcr"] == 1.0
    assert np.isnan(infos["blue"]["ac"])


@pytest.mark.parametrize("reward", REWARDS)
def test_every_reward_pays_both_agents(reward: Any) -> None:
    env = MovingOutEnv("DistancePriority", reward=reward)
    env.reset()
    _, rewards, *_ = env.step({"blue": STILL, "red": STILL})
    assert set(rewards) == {"blue", "red"}
    assert all(value < 0 for value in rewards.values())  # the step cost


def test_a_picture_is_made_when_asked_for() -> None:
    env = MovingOutEnv(render_mode="rgb_array")
    env.reset()
    picture = env.render()
    assert picture is not None
    assert picture.shape == (256, 256, 3)
    assert MovingOutEnv().render() is None


def test_wrong_arguments_and_actions_are_refused() -> None:
    with pytest.raises(WorldError, match="unknown reward 'dense'; known: paper-dense, paper-sparse, official-dense"):
        MovingOutEnv(reward="dense")  # type: ignore[arg-type]
    with pytest.raises(WorldError, match="at least 1 tick, not 0"):
        MovingOutEnv(limit_ticks=0)
    with pytest.raises(WorldError, match="unknown layout"):
        MovingOutEnv(layout="v0")
    env = MovingOutEnv()
    env.reset()
    with pytest.raises(ActionError):
        env.step({"blue": STILL, "red": STILL * np.float32(np.nan)})


def test_the_world_package_itself_needs_no_pettingzoo() -> None:

    program = (
        "import sys, world, movingout.world.metrics, movingout.world.raster; sys.exit('pettingzoo' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
