"""Motion choice: the command for the next tick is the first step of the best among a set of short moves.

A command is (distance, heading) as `World.step` takes it. The moves are predicted by the drive rules of the world
(heading errors above 0.4 rad slow a robot down; it turns at most 0.5 rad in a tick).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.navigation.geometry import wrap
from movingout.world.state import Floats

STRIDE = 0.06  # units per tick at full speed
TURN_IN_PLACE = 0.005  # a distance within the world's dead zone: the robot turns without moving
HORIZON = 3  # ticks that a short move lasts
_BENDS = np.array([0.0, 0.12, -0.12, 0.25, -0.25, 0.38, -0.38])


CollisionCost = Callable[[Floats], Floats]  # (K, HORIZON, 3) poses to (K,) costs of colliding with the partner


def no_collision_cost(moves: Floats) -> Floats:
    """Zeros: the partner is not near."""
    return np.zeros(len(moves))


class DriveCommand(NamedTuple):
    """The command of one robot for one tick."""

    distance: float
    heading: float
    grasp: bool = False


class _Fan(NamedTuple):
    distances: Floats  # (K,) of the command
    turns: Floats  # (K,) heading of the command relative to the robot, in each tick
    offsets: Floats  # (K, HORIZON, 3) pose after each tick relative to a robot at the origin with heading 0


def _make_fan() -> _Fan:
    straight = [(sign * speed, bend) for sign in (1.0, -1.0) for speed in (1.0, 0.4, 0.15) for bend in _BENDS]
    spins = [(0.0, 0.0)] + [(TURN_IN_PLACE, turn) for turn in (0.2, -0.2, 0.5, -0.5)]
    choices = np.array(straight + spins)
    poses = np.zeros((len(choices), HORIZON, 3))
    for row, (distance, turn) in enumerate(choices):
        x = y = angle = 0.0
        for tick in range(HORIZON):
            angle += turn
            if abs(distance) > TURN_IN_PLACE:
                x += -STRIDE * distance * math.sin(angle)
                y += STRIDE * distance * math.cos(angle)
            poses[row, tick] = x, y, angle
    return _Fan(choices[:, 0], choices[:, 1], poses)


_FAN = _make_fan()


def short_moves(pose: Floats) -> Floats:
    """(K, HORIZON, 3) poses after each tick of every short move, from a robot's pose (3,)."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    moves = np.empty_like(_FAN.offsets)
    moves[..., 0] = pose[0] + cos * _FAN.offsets[..., 0] - sin * _FAN.offsets[..., 1]
    moves[..., 1] = pose[1] + sin * _FAN.offsets[..., 0] + cos * _FAN.offsets[..., 1]
    moves[..., 2] = pose[2] + _FAN.offsets[..., 2]
    return moves


def best_move(pose: Floats, cost: Callable[[Floats], Floats]) -> tuple[DriveCommand, float]:
    """The first command of the best short move, and its cost; `cost` maps (K, HORIZON, 3) poses to (K,) costs."""
    costs = cost(short_moves(pose))
    best = int(np.argmin(costs))
    return DriveCommand(float(_FAN.distances[best]), wrap(float(pose[2] + _FAN.turns[best]))), float(costs[best])


def turn_to(heading: float) -> DriveCommand:
    """Turn in place."""
    return DriveCommand(TURN_IN_PLACE, wrap(heading))


def drive(heading: float, distance: float = 1.0) -> DriveCommand:
    """Drive along a heading; the world turns the robot first where needed."""
    return DriveCommand(distance, wrap(heading))


REST = DriveCommand(0.0, 0.0)
