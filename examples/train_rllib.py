"""PPO of RLlib: one policy that plays both seats.

pip install -c constraints/rllib.txt -e '.[env]' torch==2.13.0 'ray[rllib]'
python examples/train_rllib.py 5
"""

import sys

from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from ray.tune.registry import register_env

from movingout.world.env import MovingOutEnv

iterations = int(sys.argv[1]) if len(sys.argv) > 1 else 5

register_env("movingout", lambda options: ParallelPettingZooEnv(MovingOutEnv(**options)))
config = (
    PPOConfig()
    .environment("movingout", env_config={"map": "HandOff", "layout": "aware-v1", "limit_ticks": 200})
    .env_runners(num_env_runners=0)
    .multi_agent(policies={"shared"}, policy_mapping_fn=lambda agent, *_, **__: "shared")
    .training(train_batch_size=1000, minibatch_size=250, num_epochs=4)
)
algorithm = config.build_algo()
for iteration in range(1, iterations + 1):
    result = algorithm.train()["env_runners"]
    print(f"iteration {iteration}: return {result['episode_return_mean']:+.2f}")
algorithm.stop()
