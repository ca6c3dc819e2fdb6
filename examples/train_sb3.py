"""PPO of Stable-Baselines3, for one seat beside a partner, and for both seats through SuperSuit.

pip install -c constraints/sb3.txt -e '.[env]' torch==2.13.0 stable-baselines3 supersuit
python examples/train_sb3.py 20000 ppo.zip
"""

import sys

import gymnasium
import supersuit
from stable_baselines3 import PPO

import movingout  # noqa: F401  makes MovingOut-v1 known to Gymnasium
from movingout.world.env import MovingOutEnv

steps = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
file = sys.argv[2] if len(sys.argv) > 2 else ""  # `movingout match --red sb3:path=FILE`

one_seat = gymnasium.make("MovingOut-v1", map="HandOff", partner=["scripted", "idle"], seat="blue", limit_ticks=200)
model = PPO("MlpPolicy", one_seat, n_steps=256).learn(steps)
print("one seat: ", model.num_timesteps, "steps")
if file:
    model.save(file)

both_seats = supersuit.pettingzoo_env_to_vec_env_v1(MovingOutEnv("HandOff", layout="aware-v1", limit_ticks=200))
both_seats = supersuit.concat_vec_envs_v1(both_seats, 4, num_cpus=0, base_class="stable_baselines3")
print("both seats:", PPO("MlpPolicy", both_seats, n_steps=64).learn(steps).num_timesteps, "steps")
