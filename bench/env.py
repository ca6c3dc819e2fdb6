"""Ticks per second of the environment for reinforcement learning, by reward; on the CPU clock of one core.

The rewards take turns, so that what else the machine does falls on all of them: the best round gives a rate, the median
of the rounds a ratio.
"""

import statistics
import time

import numpy as np

from bench import print_table
from movingout.maps import map_names
from movingout.world.env import REWARDS, MovingOutEnv, RewardName

TICKS = 300
LIMIT_TICKS = 300
ROUNDS = 20
LEAST_SHARE = 0.85  # of the sparse reward's rate that the dense ones are to reach
SPARSE: RewardName = "paper-sparse"
DENSE: tuple[RewardName, ...] = ("paper-dense", "paper-agent-distance", "official-dense")


def main() -> None:
    rows = []
    for name in map_names():
        rounds = [_round(name) for _ in range(ROUNDS)]
        rates = [f"{max(rates[reward] for rates in rounds):,.0f}" for reward in REWARDS]
        rows.append([name, *rates, *(f"{_share(rounds, reward):.2f}" for reward in DENSE)])
    heads = ["map", *REWARDS, *(f"{reward} / {SPARSE}" for reward in DENSE)]
    print_table(f"MovingOutEnv, ticks per second with random actions (ratios to reach: {LEAST_SHARE})", heads, rows)


def _round(map_name: str) -> dict[RewardName, float]:
    return {reward: _rate(MovingOutEnv(map_name, reward=reward, limit_ticks=LIMIT_TICKS)) for reward in REWARDS}


def _share(rounds: list[dict[RewardName, float]], reward: RewardName) -> float:
    return statistics.median(rates[reward] / rates[SPARSE] for rates in rounds)


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
