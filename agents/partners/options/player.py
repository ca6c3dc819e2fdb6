"""A partner that chooses among options by scores, at every event and a few times a second; what it does is fixed."""

import math
from collections.abc import Callable
from random import Random

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.partners.options.features import OptionFeatures, Singles
from movingout.agents.partners.options.option import WAIT, RobotOption, command_of, offered
from movingout.agents.partners.walking import Perceiver, StuckRecovery
from movingout.agents.scripted.navigation.motion_choice import DriveCommand
from movingout.agents.scripted.perception import Perception

DECIDES_EVERY = 12  # ticks, where nothing happens
Scores = Callable[[Singles], Singles]
"""Features (K, SIZE) of K options to their scores (K,): logarithms of probabilities, but for a constant."""


class OptionPlayer:
    """Plays one seat. Deterministic given its options and the episode."""

    execute_rows = 1

    def __init__(self, scores: Scores, seed: int = 0, temperature: float = 1.0) -> None:
        """`temperature`: scores are divided by it before one is drawn; 0 takes the best."""
        self._scores, self.seed, self.temperature = scores, seed, temperature
        self.detail: dict[str, object] = {}

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode."""
        self._random = Random(f"options/{self.seed}/{episode.seed}/{episode.seat}")
        self._perceiver = Perceiver(episode.map, episode.seat)
        self._recovery = StuckRecovery(self._random)
        self._features = OptionFeatures(episode)
        self._option, self._decided = WAIT, -1
        self._known: tuple[int, int, bytes] | None = None  # hands and deliveries at the last decision

    def act(self, observation: Observation) -> ActionChunk:
        """A chunk of one row."""
        now = self._perceiver.perceive(observation.state)
        self._features.see(now)
        if now.own_item >= 0 and now.delivered[now.own_item]:
            command = command_of(RobotOption("let go", now.own_item), now)
        else:
            command = self._next(now)
        command = self._recovery.unstuck(now, command)
        return np.array([[command.distance, math.cos(command.heading), math.sin(command.heading), command.grasp]])

    def draw(self, tick: int, features: Singles) -> int:
        """Which of the options is chosen."""
        scores = self._scores(features).astype(np.float64)
        if self.temperature == 0.0:
            return int(np.argmax(scores))
        weights = np.exp((scores - scores.max()) / self.temperature)
        return self._random.choices(range(len(weights)), weights.tolist())[0]

    def _is_due(self, now: Perception) -> bool:
        """Whether something was taken, let go of or delivered, or the last decision is old."""
        known = now.own_item, now.partner_item, now.delivered.tobytes()
        happened, self._known = known != self._known, known
        return happened or now.tick - self._decided >= DECIDES_EVERY

    def _decide(self, now: Perception) -> None:
        options = offered(now)
        self._option = options[self.draw(now.tick, self._features.of(now, options))]
        self._features.chosen(self._option, now)
        self._decided = now.tick

    def _next(self, now: Perception) -> DriveCommand:
        if self._is_due(now):
            self._decide(now)
        return command_of(self._option, now)
