"""MAPPO of BenchMARL: both seats learn together, on the shared state.

pip install -c constraints/benchmarl.txt -e '.[env]' torch==2.13.0 benchmarl
python examples/train_benchmarl.py 60000
"""

import sys
import tempfile
from collections.abc import Callable

from benchmarl.algorithms import MappoConfig
from benchmarl.environments.pettingzoo.common import PettingZooClass
from benchmarl.experiment import Callback, Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
from tensordict import TensorDictBase
from torchrl.envs import EnvBase, PettingZooWrapper

from movingout.world.env import MovingOutEnv

FRAMES_PER_ITERATION = 1_000


class MovingOut(PettingZooClass):
    """Our environment for BenchMARL; `config` has the arguments of `MovingOutEnv`."""

    def get_env_fun(
        self, num_envs: int, continuous_actions: bool, seed: int | None, device: object
    ) -> Callable[[], EnvBase]:
        return lambda: PettingZooWrapper(
            MovingOutEnv(**self.config),
            group_map={"robots": ["blue", "red"]},  # one group: they share a network and a critic
            return_state=True,
            categorical_actions=False,
            seed=seed,
            device=device,
        )

    def supports_continuous_actions(self) -> bool:
        return True

    def supports_discrete_actions(self) -> bool:
        return False

    def has_render(self, env: EnvBase) -> bool:
        return False

    def has_state(self) -> bool:
        return True

    def max_steps(self, env: EnvBase) -> int:
        return int(self.config["limit_ticks"])

    @staticmethod
    def env_name() -> str:
        return "movingout"


class Progress(Callback):
    """Prints the mean reward per tick of each iteration."""

    def on_batch_collected(self, batch: TensorDictBase) -> None:
        reward = float(batch["next", "robots", "reward"].mean())
        print(f"iteration {self.experiment.n_iters_performed + 1}: reward per tick {reward:+.4f}")


def main(frames: int) -> None:
    config = ExperimentConfig.get_from_yaml()
    config.max_n_frames = frames
    config.on_policy_collected_frames_per_batch = FRAMES_PER_ITERATION
    config.on_policy_n_envs_per_worker = 4
    config.on_policy_n_minibatch_iters = 10
    config.lr = 3e-4
    config.loggers, config.evaluation, config.create_json = [], False, False
    config.save_folder = tempfile.mkdtemp()
    experiment = Experiment(
        task=MovingOut("hand-off", {"map": "HandOff", "layout": "aware-v1", "limit_ticks": 200}),
        algorithm_config=MappoConfig.get_from_yaml(),
        model_config=MlpConfig.get_from_yaml(),
        critic_model_config=MlpConfig.get_from_yaml(),
        seed=0,
        config=config,
        callbacks=[Progress()],
    )
    experiment.run()
    print(f"{experiment.total_frames} steps of MAPPO")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 60_000)
