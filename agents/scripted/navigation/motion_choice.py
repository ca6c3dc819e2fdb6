"""Choosing one command for the next tick: try a fan of short moves and take the one that ends best.

A command is (distance, heading) as `World.step` wants it. The short moves are predicted by the drive rules of the
world (heading errors from 0.4 rad on slow a robot down; at most 0.5 rad of turn in a tick).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.navigation.geometry import wrap
from movingout.world.state import Floats

STRIDE = 0.06  # distance of one tick at full speed
TURN_IN_PLACE = 0.005  # a distance below the world's dead zone: turns, does not move
HORIZON = 3  # ticks that a short move lasts
_BENDS = np.array([0.0, 0.12, -0.12, 0.25, -0.25, 0.38, -0.38])


CollisionCost = Callable[[Floats], Floats]  # (K, HORIZON, 3) poses to (K,) costs of meeting the partner


def no_collision_cost(moves: Floats) -> Floats:
    """Nobody is near."""
    return np.zeros(len(moves))


class DriveCommand(NamedTuple):
    """What one robot does in one tick."""

    distance: float
    heading: float
    grasp: bool = False


class _Fan(NamedTuple):
    distances: Floats  # (K,) of the command
    turns: Floats  # (K,) heading of the command relative to the robot, each tick anew
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
    """(K, HORIZON, 3) poses after each tick of every move in the fan, from a robot's pose (3,)."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    moves = np.empty_like(_FAN.offsets)
    moves[..., 0] = pose[0] + cos * _FAN.offsets[..., 0] - sin * _FAN.offsets[..., 1]
    moves[..., 1] = pose[1] + sin * _FAN.offsets[..., 0] + cos * _FAN.offsets[..., 1]
    moves[..., 2] = pose[2] + _FAN.offsets[..., 2]
    return moves


def best_move(pose: Floats, cost: Callable[[Floats], Floats]) -> tuple[DriveCommand, float]:
    """The command that starts the best short move, and its cost; `cost` maps (K, HORIZON, 3) poses to (K,) costs."""
    costs = cost(short_moves(pose))
    best = int(np.argmin(costs))
    return DriveCommand(float(_FAN.distances[best]), wrap(float(pose[2] + _FAN.turns[best]))), float(costs[best])


def turn_to(heading: float) -> DriveCommand:
    """Turn on the spot."""
    return DriveCommand(TURN_IN_PLACE, wrap(heading))


def drive(heading: float, distance: float = 1.0) -> DriveCommand:
    """Go along a heading (the world turns first where it must)."""
    return DriveCommand(distance, wrap(heading))


REST = DriveCommand(0.0, 0.0)
