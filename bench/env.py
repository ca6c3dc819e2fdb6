"""Ticks per second of the environment for reinforcement learning, by reward; on the CPU clock of one core.

The rewards take turns, so that what else the machine does falls on all of them; the best of the rounds counts.
"""

import time

import numpy as np

from bench import print_table
from movingout.maps import map_names
from movingout.world.env import REWARDS, MovingOutEnv, RewardName

TICKS = 1500
LIMIT_TICKS = 300
ROUNDS = 5
LEAST_SHARE = 0.85  # of the sparse reward's rate that the dense one is to reach


def main() -> None:
    rows = []
    for name in map_names():
        rates = _rates(name)
        share = rates["paper-dense"] / rates["paper-sparse"]
        rows.append([name, *(f"{rates[reward]:,.0f}" for reward in REWARDS), f"{share:.2f}"])
    heads = ["map", *REWARDS, f"dense / sparse (to reach: {LEAST_SHARE})"]
    print_table("MovingOutEnv, ticks per second with random actions", heads, rows)


def _rates(map_name: str) -> dict[RewardName, float]:
    best = dict.fromkeys(REWARDS, 0.0)
    for _ in range(ROUNDS):
        for reward in REWARDS:
            best[reward] = max(best[reward], _rate(MovingOutEnv(map_name, reward=reward, limit_ticks=LIMIT_TICKS)))
    return best


def _rate(env: MovingOutEnv) -> float:
    generator = np.random.default_rng(0)
    rows = generator.uniform([-1, -1, -1, 0], 1, (TICKS, 2, 4)).astype(np.float32)
    actions = [dict(zip(env.possible_agents, pair, strict=True)) for pair in rows]
    env.reset(seed=0)
    start = time.process_time()
    for action in actions:
        env.step(action)
        if not env.agents:
            env.reset()
    return TICKS / (time.process_time() - start)
