"""Actions of a policy that was trained behind a wrapper of Gymnasium mean in a seat what they meant in training."""

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.wrappers import ClipAction, RescaleAction

from movingout.agents.adapters.action_box import action_box
from movingout.agents.environment.seat_env import SeatEnv
from movingout.agents.errors import AgentError


class Told(gymnasium.ActionWrapper):
    """Keeps the action that reaches the environment."""

    def action(self, action: np.ndarray) -> np.ndarray:
        self.seen = np.array(action)
        return action


@pytest.mark.parametrize(
    "wrap",
    [
        lambda env: env,
        lambda env: RescaleAction(env, np.float32(-1), np.float32(1)),
        lambda env: RescaleAction(env, np.float32(0), np.float32(10)),
        ClipAction,
    ],
)
def test_an_action_is_the_one_that_the_wrapper_gave_the_environment(wrap: type[ClipAction]) -> None:
    told = Told(SeatEnv(partner="idle"))
    env = wrap(told)
    env.reset(seed=0)
    assert isinstance(env.action_space, spaces.Box)
    rescaled = True if env.action_space.high[0] == 10 else None
    box = action_box(env.action_space.low, env.action_space.high, rescaled)
    random = np.random.default_rng(1)
    low, high = np.maximum(env.action_space.low, [-1, -1, -1, 0]), np.minimum(env.action_space.high, 10)
    for _ in range(5):
        action = random.uniform(low, np.minimum(high, 1) if wrap is ClipAction else high).astype(np.float32)
        env.step(action)
        assert np.allclose(box.ours(action[None]), [told.seen], atol=1e-6)


@pytest.mark.parametrize(
    ("low", "high"),
    [
        ([0, -1, -1, 0], [1, 1, 1, 1]),
        ([-1, -1, -1, -1], [1, 1, 1, 2]),
        ([-np.inf, -1, -1, 0], [np.inf, 1, 1, 1]),
        ([0, 0, 0, 0], [np.inf] * 4),
        ([1, 1, 1, 1], [1, 1, 1, 1]),
    ],
)
def test_other_ranges_are_refused_with_a_sentence(low: list[float], high: list[float]) -> None:
    with pytest.raises(AgentError, match=r"the model's actions go from \[.* go from \[-1, -1, -1, 0\] to \[1, 1, 1, 1"):
        action_box(low, high)


def test_four_equal_ranges_but_for_the_usual_one_are_not_guessed_to_be_rescaled() -> None:
    low, high = [-2.0] * 4, [2.0] * 4
    with pytest.raises(AgentError, match=r"all go from -2 to 2: say rescaled=yes if .*, or rescaled=no if"):
        action_box(low, high)
    action = [1.0, 0.0, 1.0, 0.0]
    assert action_box(low, high, rescaled=True).ours(action).tolist() == [0.5, 0.0, 0.5, 0.5]
    assert action_box(low, high, rescaled=False).ours(action).tolist() == action
    assert action_box([-1] * 4, [1] * 4).ours(action).tolist() == [1.0, 0.0, 1.0, 0.5]
    assert action_box([-1] * 4, [1] * 4, rescaled=False).ours(action).tolist() == action
