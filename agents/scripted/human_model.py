"""A scripted person: the scripted agent's plans with human perception and motor control.

This module adds, according to the style, the delay with which the partner is seen, speed, steering error, hesitation
and the keyboard; the habits that affect plans are applied by `ScriptedAgent`.
"""

import math
from collections import deque
from dataclasses import fields, replace

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe
from movingout.agents.scripted import ScriptedAgent
from movingout.agents.scripted.keyboard_model import KeyboardModel
from movingout.agents.scripted.populations import scripted_person
from movingout.agents.scripted.style import Style
from movingout.maps.suggestion import known_names
from movingout.world.state import Floats, WorldState

ERROR_CORRELATION = 0.9  # correlation of the steering error between two ticks
PAUSE_TICKS = 3


class HumanModel:
    """One scripted person as an agent. Deterministic given name, seed and episode."""

    execute_rows = 1

    def __init__(self, name: str = "A01", seed: int = 0, **habits: float | str) -> None:
        """`name`: A01 to C20, as in the populations. `habits`: fields of `Style` to change.

        Raises DataError for an unknown name and AgentError for an unknown habit.
        """
        known = [field.name for field in fields(Style)]
        wrong = [habit for habit in habits if habit not in known]
        if wrong:
            raise AgentError(f"style: no habit {wrong[0]!r}; {known_names(wrong[0], known)}")
        self.style: Style = replace(scripted_person(name).style, **habits)  # type: ignore[arg-type]
        self._plan = ScriptedAgent(seed=seed, adapts=False)
        self._plan.style = replace(self.style, speed=1.0, delay=0, noise=0.0, hesitation=0.0, stick=0)
        self._plan.anticipates = False
        self._name = name
        self._seed = seed

    @property
    def detail(self) -> dict[str, object]:
        """The decision trace of the planner."""
        return self._plan.detail

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode."""
        self._episode = episode
        self._plan.reset(episode)
        number = int(self._name[1:]) + 100 * ord(self._name[0])
        self._random = np.random.default_rng([number, self._seed, episode.seed, episode.seat])
        self._seen: deque[tuple[Floats, Floats]] = deque(maxlen=self.style.delay + 1)
        self._steering_error = 0.0
        self._pause = 0
        self._heading = 0.0
        self._keys = KeyboardModel(episode.map, episode.seat) if self.style.stick else None

    def act(self, observation: Observation) -> ActionChunk:
        """A chunk of one row."""
        state = self._delayed(observation.state)
        row = self._plan.act(observe(self._episode.map, state, self._episode.seat, observation.tick))[0].copy()
        wanted = math.atan2(row[2], row[1])
        if self._hesitates():
            row[0], row[3], wanted = 0.0, 0.0, self._heading
        keeps = ERROR_CORRELATION
        self._steering_error = (
            keeps * self._steering_error + math.sqrt(1 - keeps**2) * self.style.noise * self._random.standard_normal()
        )
        steered = wanted + (self._steering_error if row[0] != 0.0 else 0.0)
        self._heading = wanted
        distance = row[0] * self.style.speed
        if self._keys is not None:
            distance, steered = self._keys.press(state, distance, steered)
        return np.array([[distance, math.cos(steered), math.sin(steered), row[3]]])

    def _delayed(self, state: WorldState) -> WorldState:
        """The state with the partner as it was `delay` ticks ago, but without delay while both hold the same item."""
        other = 1 - self._episode.seat
        self._seen.append((state.robot_poses[other], state.robot_velocities[other]))
        if state.held[0] >= 0 and state.held[0] == state.held[1]:
            return state
        poses, velocities = state.robot_poses.copy(), state.robot_velocities.copy()
        poses[other], velocities[other] = self._seen[0]
        return replace(state, robot_poses=poses, robot_velocities=velocities)

    def _hesitates(self) -> bool:
        if self._pause == 0 and self._random.random() < self.style.hesitation:
            self._pause = PAUSE_TICKS
        self._pause = max(self._pause - 1, 0)
        return self._pause > 0
