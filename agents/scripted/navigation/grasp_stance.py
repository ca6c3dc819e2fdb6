"""Stances: poses beside an item from which a robot can grab it."""

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from movingout.agents.scripted.navigation.geometry import forward, signed_distance
from movingout.maps import ItemSpec
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.constants import REACH, REACH_TOLERANCE
from movingout.world.state import Floats

GAP = 0.012  # units between robot and item when it grabs: nearly the gripper's reach
_ABOUT = 0.5  # cosine of the angle within which two headings are similar
HEADINGS: Floats = np.arange(32) * math.pi / 16
_TURNS: Floats = np.array(sorted(np.arange(-20, 21) * math.pi / 20, key=abs))  # least first
_SURELY = 0.006  # units within the reach
_DISTANCES: Floats = np.arange(0.13, 0.5, 0.004)


def within_reach(item: ItemSpec, item_pose: Floats, robot_pose: Floats, slack: float = 0.002) -> bool:
    """Whether a grab from `robot_pose` (3,) succeeds: a probe point ahead must be nearer than the tolerance."""
    dx, dy = forward(float(robot_pose[2]))
    probe = np.array([[robot_pose[0] + REACH * dx, robot_pose[1] + REACH * dy]])
    return float(signed_distance(item, item_pose, probe)[0]) < REACH_TOLERANCE - slack


def reaching_heading(item: ItemSpec, item_pose: Floats, robot_pose: Floats) -> float | None:
    """The heading nearest to the present one in which a robot that only turns can grab the item; None for none."""
    turns = robot_pose[2] + _TURNS
    probes = robot_pose[:2] + REACH * np.stack([-np.sin(turns), np.cos(turns)], axis=1)
    reached = np.flatnonzero(signed_distance(item, item_pose, probes) < REACH_TOLERANCE - _SURELY)
    return float(turns[reached[0]]) if reached.size else None


def stances(item: ItemSpec, item_pose: Floats) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Poses (32, 3) around an item, each facing its centre, and from which of them it can be grabbed (32,).

    Beside a pointed shape the robot may touch a corner before its gripper reaches the surface ahead.
    """
    return _stances(item, *(round(float(number), 4) for number in item_pose))


@lru_cache(maxsize=256)
def _stances(item: ItemSpec, x: float, y: float, angle: float) -> tuple[Floats, npt.NDArray[np.bool_]]:
    pose = np.array([x, y, angle])
    ahead = np.stack([-np.sin(HEADINGS), np.cos(HEADINGS)], axis=1)
    centres = pose[:2] - ahead[:, None, :] * _DISTANCES[:, None]  # (32, distances, 2)
    room = signed_distance(item, pose, centres.reshape(-1, 2)).reshape(len(HEADINGS), -1)
    nearest = np.argmax(room >= ROBOT_RADIUS + GAP, axis=1)
    places = centres[np.arange(len(HEADINGS)), nearest]
    gaps = signed_distance(item, pose, places + REACH * ahead)
    return np.column_stack([places, HEADINGS]), gaps < REACH_TOLERANCE + 0.6 * GAP


def stances_facing(heading: float) -> set[int]:
    """The numbers of the stances with about this heading."""
    return set(np.flatnonzero(np.cos(HEADINGS - heading) > _ABOUT).tolist())


def in_frame(robot_pose: Floats, item_pose: Floats) -> tuple[float, float, float]:
    """The item's pose in the robot's frame, which is constant while the robot holds it."""
    cos, sin = math.cos(robot_pose[2]), math.sin(robot_pose[2])
    dx, dy = float(item_pose[0] - robot_pose[0]), float(item_pose[1] - robot_pose[1])
    return cos * dx + sin * dy, -sin * dx + cos * dy, float(item_pose[2] - robot_pose[2])
