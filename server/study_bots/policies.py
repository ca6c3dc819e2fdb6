"""Policies that steer the robot of a simulated participant."""

import math
from typing import NamedTuple, Protocol

import numpy as np

from movingout.agents.base import EpisodeInfo
from movingout.agents.observation.seat_observation import observe
from movingout.agents.scripted.human_model import HumanModel
from movingout.maps import MapSpec
from movingout.server.frames import Bundle
from movingout.world.constants import POSE_SECONDS, TICK_SECONDS
from movingout.world.state import WorldState

PRESS_COOLDOWN = 2  # ticks after a press in which its effect is not visible yet


class StickInput(NamedTuple):
    """The input of one tick."""

    move: float  # [-1, 1]
    heading: float  # rad
    press: bool


class SeatPolicy(Protocol):
    """Plays one seat of one round at a time."""

    def begin(self, the_map: MapSpec, seat: int, ticks: int) -> None: ...

    def steer(self, bundle: Bundle) -> StickInput: ...


class ScriptedPolicy:
    """A person (agents/scripted/human_model.py) that observes only what the wire carries: poses and held items."""

    def __init__(self, name: str, seed: int) -> None:
        self._person = HumanModel(name, seed)
        self._seed = seed

    def begin(self, the_map: MapSpec, seat: int, ticks: int) -> None:
        self._map, self._seat = the_map, seat
        self._pressed_at = -PRESS_COOLDOWN
        self._person.reset(EpisodeInfo(the_map, seat, self._seed, ticks))

    def steer(self, bundle: Bundle) -> StickInput:
        row = self._person.act(observe(self._map, state_of(bundle), self._seat))[0]
        press = row[3] > 0.5 and bundle.tick - self._pressed_at > PRESS_COOLDOWN
        if press:
            self._pressed_at = bundle.tick
        return StickInput(float(np.clip(row[0], -1, 1)), math.atan2(row[2], row[1]), press)


class CirclingPolicy:
    """Drives in circles and presses now and then: costs no CPU time, for measuring the server alone."""

    def begin(self, the_map: MapSpec, seat: int, ticks: int) -> None:
        self._seat = seat

    def steer(self, bundle: Bundle) -> StickInput:
        return StickInput(
            1.0, math.remainder(bundle.tick * TICK_SECONDS + self._seat, 2 * math.pi), bundle.tick % 30 == 0
        )


def state_of(bundle: Bundle) -> WorldState:
    """The state at the end of a bundle; velocities are averages over its last 20 ms."""
    poses, before = bundle.poses[-1], bundle.poses[-2]
    steps = poses[:2] - before[:2]
    steps[:, 2] = np.remainder(steps[:, 2] + math.pi, 2 * math.pi) - math.pi
    return WorldState(
        tick=bundle.tick,
        robot_poses=poses[:2].copy(),
        robot_velocities=steps / POSE_SECONDS,
        held=np.array(bundle.held),
        item_poses=poses[2:].copy(),
    )
