"""Pairs of grasps with which two robots can carry a heavy item, and what each costs."""

import itertools
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from movingout.agents.scripted.navigation.free_space import FreeSpace, sample
from movingout.agents.scripted.navigation.geometry import heading_of, wrap
from movingout.agents.scripted.navigation.grasp_stance import stances
from movingout.agents.scripted.perception import Perception
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats

DISTINCT_ANGLE = 0.7  # rad by which distinct grasps differ
LEAST_DISTANCE, PREFERRED_DISTANCE = 0.255, 0.33  # units between the robots' centres: required, and preferred
COMFORTABLE_ROOM, CRAMPED = 0.04, 1000.0  # units around a stance; quarter ticks per missing unit
NOT_OPPOSITE_COST = 12.0  # quarter ticks per radian by which two grasps are not opposite


class GraspPair(NamedTuple):
    """Stances of both robots at an item: poses (2, 3) in seat order, and the cost of reaching them."""

    score: float
    robots: Floats


def grasp_pairs(now: Perception, item: int, mine: list[float], theirs: list[float]) -> list[GraspPair]:
    """Pairs of stances, quickest to reach first. Both robots compute the same order."""
    poses, _ = stances(now.item(item), now.item_pose(item))
    blue_costs, red_costs = (mine, theirs) if now.seat == 0 else (theirs, mine)
    options = []
    for blue, red, sideways, tightness in _pairs(poses.tobytes()):
        slower, quicker = sorted((blue_costs[blue], red_costs[red]))[::-1]
        if slower < UNREACHED:
            options.append((round(slower + 0.2 * quicker + sideways + tightness), blue, red))
    return [GraspPair(float(score), poses[[blue, red]]) for score, blue, red in sorted(options)]


@lru_cache(maxsize=64)
def _pairs(stances_beside: bytes) -> list[tuple[int, int, float, float]]:
    """Stances (n, 3) of blue and red that can be taken at once: both numbers, and two costs of the pair."""
    poses = np.frombuffer(stances_beside).reshape(-1, 3)
    pairs = []
    for blue, red in itertools.product(range(len(poses)), repeat=2):
        apart = abs(wrap(float(poses[blue, 2] - poses[red, 2])))
        gap = math.dist(poses[blue, :2], poses[red, :2])
        if gap > LEAST_DISTANCE:
            pairs.append((blue, red, NOT_OPPOSITE_COST * (math.pi - apart), _tightness(gap)))
    return pairs


def distinct_grasps(options: list[GraspPair], most: int = 6) -> list[GraspPair]:
    """The first option, and the following ones that differ from all chosen before in at least one stance."""
    chosen: list[GraspPair] = []
    for option in options:
        turns = (np.abs(_wrapped(option.robots[:, 2] - other.robots[:, 2])).max() for other in chosen)
        if all(turn > DISTINCT_ANGLE for turn in turns):
            chosen.append(option)
        if len(chosen) == most:
            break
    return chosen


def _wrapped(angles: Floats) -> Floats:
    return np.asarray((angles + math.pi) % (2 * math.pi) - math.pi)


def _tightness(gap: float) -> float:
    """The cost of two stances so near to each other that one robot may block the other."""
    return max(PREFERRED_DISTANCE - gap, 0.0) * 1000.0


def tight_stance_costs(now: Perception, space: FreeSpace, item: int) -> Floats:
    """(32,) the cost of stances with so little room that imprecise steering fails; `space` is without the item."""
    poses, _ = stances(now.item(item), now.item_pose(item))
    room = sample(space.clearance, poses[:, 0], poses[:, 1]) - ROBOT_RADIUS
    return CRAMPED * np.maximum(COMFORTABLE_ROOM - room, 0.0)


def grasps_beside_partner(now: Perception, item: int, mine: list[float]) -> list[GraspPair]:
    """Stances that go with the partner's grasp, opposite and near ones first."""
    poses, _ = stances(now.item(item), now.item_pose(item))
    centre = now.item_pose(item)
    theirs = heading_of(float(centre[0] - now.partner[0]), float(centre[1] - now.partner[1]))
    options = []
    for number, pose in enumerate(poses):
        apart = abs(wrap(float(pose[2]) - theirs))
        gap = math.dist(pose[:2], now.partner[:2])
        if mine[number] < UNREACHED and gap > LEAST_DISTANCE:
            robots = np.stack([pose, now.partner] if now.seat == 0 else [now.partner, pose])
            score = mine[number] + 2 * NOT_OPPOSITE_COST * (math.pi - apart) + _tightness(gap)
            options.append((score, number, robots))
    return [GraspPair(score, robots) for score, _, robots in sorted(options, key=lambda option: option[:2])]
