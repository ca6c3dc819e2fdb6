"""Train robomimic's BC on an export of recordings, and roll it out in the environment that the file names.

    movingout recordings export data/recordings --to robomimic --out demos.hdf5
    python examples/train_robomimic.py demos.hdf5 2000 3          # 2000 updates, 3 episodes

robomimic 0.3 makes its environments with `gym`, the predecessor of Gymnasium, whose last release does not run with
NumPy 2. `OldGym` stands in for what robomimic asks of it. docs/exports.md says what to install.
"""

import sys
import types
from typing import Any

import gymnasium
import numpy as np


class OldGym(gymnasium.Wrapper):  # type: ignore[misc]
    """A Gymnasium environment with `gym`'s `reset` and `step`: no info at the start, one flag for the end."""

    def reset(self, **arguments: Any) -> Any:
        return self.env.reset(**arguments)[0]

    def step(self, action: Any) -> Any:
        observation, reward, terminated, truncated, info = self.env.step(np.asarray(action, dtype=np.float32))
        return observation, reward, terminated or truncated, info

    def render(self, mode: str = "rgb_array", **_: Any) -> Any:
        return self.env.render()


def make(name: str, **arguments: Any) -> OldGym:
    return OldGym(gymnasium.make(name, render_mode="rgb_array", disable_env_checker=True, **arguments))


old_gym = types.ModuleType("gym")
old_gym.make = make  # type: ignore[attr-defined]
sys.modules["gym"] = old_gym  # before robomimic imports it


def train(file: str, updates: int) -> Any:
    """A BC policy that was trained for so many updates, as robomimic rolls it out."""
    import robomimic.utils.file_utils as files
    import robomimic.utils.obs_utils as observations
    import torch
    from robomimic.algo import RolloutPolicy, algo_factory
    from robomimic.config import config_factory
    from robomimic.utils.dataset import SequenceDataset

    config = config_factory("bc")
    with config.values_unlocked():
        config.observation.modalities.obs.low_dim = ["flat"]
        config.train.data = file
    observations.initialize_obs_utils_with_config(config)
    shapes = files.get_shape_metadata_from_dataset(file, all_obs_keys=["flat"])
    model = algo_factory("bc", config, shapes["all_shapes"], shapes["ac_dim"], torch.device("cpu"))
    data = SequenceDataset(file, obs_keys=["flat"], dataset_keys=["actions", "rewards", "dones"])
    loader = torch.utils.data.DataLoader(data, batch_size=100, shuffle=True)
    model.set_train()
    done = 0
    while done < updates:
        for batch in loader:
            batch = model.process_batch_for_training(batch)
            model.train_on_batch(model.postprocess_batch_for_training(batch, obs_normalization_stats=None), epoch=1)
            done += 1
            if done == updates:
                break
    print(f"{updates} updates of BC on {len(data)} samples")
    return RolloutPolicy(model)


def roll_out(policy: Any, file: str, episodes: int) -> None:
    """Play episodes in the environment of the file, by robomimic's own loop."""
    import robomimic.utils.env_utils as environments
    import robomimic.utils.file_utils as files
    from robomimic.utils.train_utils import run_rollout

    env = environments.create_env_from_metadata(files.get_env_metadata_from_dataset(file))
    for number in range(episodes):
        result = run_rollout(policy, env, horizon=500)
        print(f"episode {number + 1}: {result['Horizon']} ticks, return {result['Return']:.2f}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    roll_out(train(sys.argv[1], int(sys.argv[2])), sys.argv[1], int(sys.argv[3]))
