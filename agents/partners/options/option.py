"""Options (Sutton, Precup and Singh 1999): what a robot can do next, and how a fixed controller does it.

A policy chooses; walking, grabbing and carrying are those of the simple partners and are not learned.
"""

import math
from typing import Literal, NamedTuple

import numpy as np

from movingout.agents.partners.walking import Point, drive_along, go_and_grab, walk
from movingout.agents.scripted.navigation.free_space import AXIS
from movingout.agents.scripted.navigation.geometry import heading_of, wrap
from movingout.agents.scripted.navigation.motion_choice import REST, DriveCommand, drive
from movingout.agents.scripted.perception import Perception
from movingout.maps.shapes import circumradius
from movingout.maps.spec import GOAL_MARGIN

Kind = Literal["take", "carry", "let go", "wait"]
KINDS: tuple[Kind, ...] = "take", "carry", "let go", "wait"
MOST_OPTIONS = 16  # that a network looks at; items beyond are the ones farthest away
GIVES_ROOM = 0.4  # units between two robots below which one that waits moves away
_SHIFTS_WITHIN = 0.35  # units from its spot at which an item is shifted without being turned


class RobotOption(NamedTuple):
    """One thing to do. `spot` is where a carried item is to lie, in goal region `goal`."""

    kind: Kind
    item: int = -1
    goal: int = -1
    spot: Point = (0.0, 0.0)

    def goes_on(self, other: "RobotOption") -> bool:
        """Whether this is the same as `other`, but for the spot, which depends on what lies around it."""
        return self[:3] == other[:3]


WAIT = RobotOption("wait")


def offered(now: Perception) -> list[RobotOption]:
    """What can be done next, at most `MOST_OPTIONS`; waiting is always among it.

    With an empty hand: any item that is not delivered, but for light ones that the partner has. With an item: each
    goal region, and letting go.
    """
    item = now.own_item
    if item >= 0:
        regions = range(len(now.map.goals))
        carried = [RobotOption("carry", item, goal, spot_in(now, item, goal)) for goal in regions]
        return [WAIT, RobotOption("let go", item), *carried[: MOST_OPTIONS - 2]]
    shared = now.partner_item
    items = [*now.waiting, *([shared] if shared >= 0 and now.is_heavy(shared) and not now.delivered[shared] else [])]
    if len(items) > MOST_OPTIONS - 1:
        items = sorted(items, key=lambda one: math.dist(now.item_pose(one)[:2], now.pose[:2]))[: MOST_OPTIONS - 1]
    return [WAIT, *(RobotOption("take", one) for one in sorted(items))]


def command_of(option: RobotOption, now: Perception) -> DriveCommand:
    """The command of one tick of an option."""
    if option.kind == "take":
        return go_and_grab(now, option.item)
    if option.kind == "let go":
        return DriveCommand(0.0, float(now.pose[2]), grasp=True)
    return _carry(now, option) if option.kind == "carry" else _give_room(now)


def spot_in(now: Perception, item: int, goal: int) -> Point:
    """Where in a goal region an item fits beside what lies there, near its middle; else the roomiest place."""
    region, radius = now.map.goals[goal], circumradius(now.item(item).shape, now.item(item).scale)
    columns = _inside(region.left, region.right, radius)
    rows = _inside(region.bottom, region.top, radius)
    room = np.minimum(now.space((item,)).clearance[np.ix_(rows, columns)], radius)
    x, y = (region.left + region.right) / 2, (region.bottom + region.top) / 2
    away = np.hypot(AXIS[columns][None, :] - x, AXIS[rows][:, None] - y)
    row, column = np.unravel_index(int(np.argmax(room - 0.001 * away)), room.shape)
    return float(AXIS[columns[column]]), float(AXIS[rows[row]])


def _inside(low: float, high: float, radius: float) -> list[int]:
    """Grid points along an axis at which something of this radius is within the region; at least its middle."""
    middle, slack = (low + high) / 2, max((high - low) / 2 + GOAL_MARGIN - radius, 0.0)
    near = np.flatnonzero(np.abs(AXIS - middle) <= slack).tolist()
    return near or [int(np.argmin(np.abs(AXIS - middle)))]


def _carry(now: Perception, option: RobotOption) -> DriveCommand:
    pose, (x, y) = now.item_pose(option.item), option.spot
    if now.is_heavy(option.item):
        return drive_along(pose, now.space((option.item,)), [option.spot])
    dx, dy = x - float(pose[0]), y - float(pose[1])
    if math.hypot(dx, dy) > _SHIFTS_WITHIN:
        return walk(now, now.space(), [option.spot])
    heading = heading_of(dx, dy)
    backward = abs(wrap(heading - float(now.pose[2]))) > math.pi / 2
    return drive(heading + math.pi, -1.0) if backward else drive(heading)


def _give_room(now: Perception) -> DriveCommand:
    dx, dy = float(now.pose[0] - now.partner[0]), float(now.pose[1] - now.partner[1])
    if now.own_item >= 0 or math.hypot(dx, dy) > GIVES_ROOM:
        return REST
    heading = heading_of(dx, dy)
    backward = abs(wrap(heading - float(now.pose[2]))) > math.pi / 2
    return drive(heading + math.pi, -1.0) if backward else drive(heading)
