"""Evaluate a policy of your own with every shipped partner: `.venv/bin/python examples/evaluate_my_policy.py`."""

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.catalogue import agent_cards
from movingout.matches import Grid, run_grid
from movingout.matches.results.table import markdown


class MyPolicy:
    def reset(self, episode: EpisodeInfo) -> None:  # .map, .seat (0 blue, 1 red), .seed, .ticks
        self.random = np.random.default_rng([episode.seed, episode.seat])

    def act(self, observation: Observation) -> ActionChunk:  # .state, .tick, .seat, .encode(layout)
        heading = self.random.uniform(-np.pi, np.pi)
        # A row per tick: distance, cos and sin of the heading, grasp toggle.
        return np.array([[1.0, np.cos(heading), np.sin(heading), 0.0]])


if __name__ == "__main__":
    partners = [card.id for card in agent_cards()]
    grid = Grid(name="my policy", agents=["evaluate_my_policy:MyPolicy"], partners=partners, maps=["HandOff"], seeds=2)
    print(markdown(run_grid(grid, "data/matches/my-policy").rows))
