"""Late and jittery hands on any agent: its actions come late, by a lag that varies, and are steered unsteadily.

`late:agent=greedy,delay=3,jitter=0.2`; options of the agent inside are joined by semicolons
(`late:agent=greedy:order=far;patience=40`). `clone` is the same around a trained policy, with slips.
"""

import math
from collections import deque

import numpy as np

from movingout.agents.action_chunk import checked_chunk, rows_to_execute
from movingout.agents.base import ActionChunk, Agent, EpisodeInfo, Observation, Wrapper
from movingout.agents.errors import AgentError
from movingout.agents.scripted.keyboard_model import KeyboardModel
from movingout.world.state import Floats

LONGEST_DELAY = 10  # [ticks]
STEADY = 0.9  # correlation of the steering error between two ticks
LAG_CHANGES = 0.1  # per tick: the lag grows or shrinks by one
SLIP_TICKS = (3, 9)  # duration of a slip
PRESS_AGAIN_AFTER = 3  # ticks beyond the lag before a press is repeated: who waits for an effect does not press twice
_REST = np.array([0.0, 1.0, 0.0, 0.0])


class LateHands(Wrapper):
    """Plays any agent late and unsteadily. Deterministic given its options and the episode."""

    execute_rows = 1

    def __init__(
        self,
        agent: Agent,
        *,
        seed: int = 0,
        delay: int = 3,
        jitter: float = 0.15,
        slips: float = 0.0,
        keys: bool = False,
    ) -> None:
        """`delay`: mean lag [ticks]. `jitter`: standard deviation of the steering error [rad]. `slips`: probability
        per tick of a random drive for some ticks. `keys`: eight directions, full speed or none.

        Raises AgentError for a value out of range.
        """
        if type(delay) is not int or not 0 <= delay <= LONGEST_DELAY:
            raise AgentError(f"delay is a whole number of ticks from 0 to {LONGEST_DELAY}, not {delay!r}")
        if type(seed) is not int:
            raise AgentError(f"seed is a whole number, not {seed!r}")
        for name, value, most in (("jitter", jitter, 1.0), ("slips", slips, 0.2)):
            if not isinstance(value, int | float) or not 0.0 <= value <= most:
                raise AgentError(f"{name} lies between 0 and {most}, not {value!r}")
        super().__init__(agent)
        self.seed, self.delay, self.jitter, self.slips, self.keys = seed, delay, jitter, slips, bool(keys)

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode."""
        super().reset(episode)
        self._random = np.random.default_rng([0x1A7E, self.seed % 2**31, episode.seed % 2**31, episode.seat])
        self._planned: deque[Floats] = deque()
        self._queue: deque[Floats] = deque([_REST] * self.delay)
        self._error, self._last, self._presses_from = 0.0, _REST, 0
        self._slip, self._slip_left = _REST, 0
        self._keys = KeyboardModel(episode.map, episode.seat) if self.keys else None

    def act(self, observation: Observation) -> ActionChunk:
        """A chunk of one row: what was decided some ticks ago, executed unsteadily."""
        if not self._planned:
            chunk = checked_chunk(self.agent.act(observation))
            self._planned.extend(chunk[: rows_to_execute(self.agent, chunk)])
        self._queue.append(self._once_pressed(self._planned.popleft().copy(), observation.tick))
        row = self._slipped(self._due())
        self._error = STEADY * self._error + math.sqrt(1 - STEADY**2) * self.jitter * self._random.standard_normal()
        distance = float(row[0])
        heading = math.atan2(row[2], row[1]) + (self._error if distance != 0.0 else 0.0)
        if self._keys is not None:
            distance, heading = self._keys.press(observation.state, distance, heading)
        return np.array([[distance, math.cos(heading), math.sin(heading), row[3]]])

    def _once_pressed(self, row: Floats, tick: int) -> Floats:
        """The row without a press that only repeats one whose effect is still to come."""
        if row[3] > 0.5:
            if tick < self._presses_from:
                row[3] = 0.0
            else:
                self._presses_from = tick + len(self._queue) + PRESS_AGAIN_AFTER
        return row

    def _due(self) -> Floats:
        """The row to execute now: the lag varies, so at times one is repeated and at times one is skipped."""
        if self.delay and self._random.random() < LAG_CHANGES:
            if self._random.random() < 0.5 and len(self._queue) < 2 * self.delay:
                return np.array([*self._last[:3], 0.0])  # repeated, but for its press
            if len(self._queue) > 1 and self._queue[0][3] < 0.5:
                self._queue.popleft()
        self._last = self._queue.popleft()
        return self._last

    def _slipped(self, row: Floats) -> Floats:
        if self._slip_left == 0 and self.slips and self._random.random() < self.slips:
            self._slip_left = int(self._random.integers(*SLIP_TICKS))
            angle = self._random.uniform(-math.pi, math.pi)
            self._slip = np.array([self._random.uniform(0.3, 1.0), math.cos(angle), math.sin(angle), 0.0])
        if self._slip_left == 0:
            return row
        self._slip_left -= 1
        return np.array([*self._slip[:3], row[3]])
