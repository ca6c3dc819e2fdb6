"""Where to stand to grab an item, and whether the hand reaches it."""

import math

import numpy as np

from agents.scripted.geometry import forward, reach, signed_distance
from maps import ItemSpec
from maps.spec import ROBOT_RADIUS
from world.constants import REACH, REACH_TOLERANCE
from world.state import Floats

GAP = 0.012  # between robot and item when it grabs: as far as the hand reaches, nearly


def within_reach(item: ItemSpec, item_pose: Floats, robot_pose: Floats, slack: float = 0.002) -> bool:
    """Whether a grab from `robot_pose` (3,) gets the item (PHYSICS: a probe ahead, closer than the tolerance)."""
    dx, dy = forward(float(robot_pose[2]))
    probe = np.array([[robot_pose[0] + REACH * dx, robot_pose[1] + REACH * dy]])
    return float(signed_distance(item, item_pose, probe)[0]) < REACH_TOLERANCE - slack


def stand(item: ItemSpec, item_pose: Floats, heading: float, gap: float = GAP) -> Floats:
    """The pose (3,) of a robot that looks at the item's centre along `heading` with a gap between the two."""
    dx, dy = forward(heading)
    distance = ROBOT_RADIUS + gap + reach(item, heading + math.pi - float(item_pose[2]))
    return np.array([item_pose[0] - distance * dx, item_pose[1] - distance * dy, heading])


def in_frame(robot_pose: Floats, item_pose: Floats) -> tuple[float, float, float]:
    """The item's pose in the robot's frame: it stays so as long as the robot holds it."""
    cos, sin = math.cos(robot_pose[2]), math.sin(robot_pose[2])
    dx, dy = float(item_pose[0] - robot_pose[0]), float(item_pose[1] - robot_pose[1])
    return cos * dx + sin * dy, -sin * dx + cos * dy, float(item_pose[2] - robot_pose[2])
