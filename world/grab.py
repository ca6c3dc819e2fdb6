"""Grasping: finding the item in reach, taking hold of it, letting go.

What an item weighs depends on its size and on how many hold it; what is not held is static. When an item
turns from static to dynamic, the engine (pymunk 6.8 to 6.11) stops it and the bodies joined to it at that
moment. The official game behaves that way, so the order of the lines here is part of the physics.
"""

import math

import pymunk

from movingout.world import constants as c
from movingout.world.bodies import Bodies, ItemBody, RobotBody
from movingout.world.drive import EMPTY_HAND, Hand

_ALL_SHAPES = pymunk.ShapeFilter()


def toggle_hand(bodies: Bodies, seat: int) -> None:
    """Let go of what the robot holds, or take what is in reach; nothing happens when nothing is."""
    robot, partner = bodies.robots[seat], bodies.robots[1 - seat]
    if robot.item is not None:
        let_go(bodies, seat)
        return
    item = _item_in_reach(bodies, robot, partner)
    if item is not None:
        _grab(bodies.space, robot, partner, item)
    robot.hand, partner.hand = _hand(robot, partner), _hand(partner, robot)


def let_go(bodies: Bodies, seat: int) -> None:
    """Have a robot let go of what it holds."""
    robot, partner = bodies.robots[seat], bodies.robots[1 - seat]
    assert robot.item is not None
    _release(bodies.space, robot, robot.item, shared=partner.item is robot.item)
    robot.hand, partner.hand = _hand(robot, partner), _hand(partner, robot)


def hold(bodies: Bodies, seat: int, index: int) -> None:
    """Have a robot hold an item as it lies, in reach or not: to set up a scene in which it is held."""
    robot, partner = bodies.robots[seat], bodies.robots[1 - seat]
    _grab(bodies.space, robot, partner, bodies.items[index])
    robot.hand, partner.hand = _hand(robot, partner), _hand(partner, robot)


def _item_in_reach(bodies: Bodies, robot: RobotBody, partner: RobotBody) -> ItemBody | None:
    x, y = robot.body.position
    angle = robot.body.angle
    probe = (x - c.REACH * math.sin(angle), y + c.REACH * math.cos(angle))
    hits = bodies.space.point_query(probe, c.REACH_TOLERANCE, _ALL_SHAPES)
    for hit in sorted(hits, key=lambda hit: hit.distance):
        item = bodies.item_of_shape.get(hit.shape) if hit.shape is not None else None
        if item is not None and not (item.spec.size == "small" and partner.item is item):
            return item
    return None


def _grab(space: pymunk.Space, robot: RobotBody, partner: RobotBody, item: ItemBody) -> None:
    pivot = pymunk.PivotJoint(robot.body, item.body, (0, 0), item.body.world_to_local(robot.body.position))
    pivot.error_bias = 0
    gear = pymunk.GearJoint(robot.body, item.body, item.body.angle - robot.body.angle, 1)
    space.add(pivot, gear)
    robot.item = item
    robot.joints = (pivot, gear)
    if item.spec.size == "small":
        robot.turns_freely = False
        _set_dynamic(item, item.spec.mass, c.SMALL_MOMENT)
    elif item.spec.size == "middle":
        robot.turns_freely = False
        _set_dynamic(item, c.SOLO_MIDDLE_MASS, c.SOLO_MIDDLE_MOMENT)
    if partner.item is item:  # a large item stays static, and its holder pinned, until both hold it
        robot.turns_freely = partner.turns_freely = False
        _set_dynamic(item, item.spec.mass, c.SHARED_MOMENT)


def _release(space: pymunk.Space, robot: RobotBody, item: ItemBody, *, shared: bool) -> None:
    robot.turns_freely = True
    if item.spec.size != "large" or shared:
        item.body.body_type = pymunk.Body.STATIC
    if item.spec.size == "middle" and shared:
        _set_dynamic(item, c.SOLO_MIDDLE_MASS, c.SOLO_MIDDLE_MOMENT)
    for joint in robot.joints:  # one by one: the engine moves its last joint into the gap
        space.remove(joint)
    robot.item = None
    robot.joints = ()


def _hand(robot: RobotBody, partner: RobotBody) -> Hand:
    item = robot.item
    if item is None:
        return EMPTY_HAND
    small = item.spec.size == "small"
    return Hand(
        slow=item.body.mass == c.SOLO_MIDDLE_MASS,  # the official rule looks at the mass alone
        together=partner.item is item,
        aligns=not robot.turns_freely and not small,
        quick=small,
    )


def _set_dynamic(item: ItemBody, mass: float, moment: float) -> None:
    item.body.body_type = pymunk.Body.DYNAMIC
    item.body.mass = mass
    item.body.moment = moment
