"""Builds the engine's world from a map: arena, goals, items, robots, walls, in the official order.

The order is part of the physics: it decides in which order contacts and joints are solved, so changing it changes
trajectories. Nothing here knows about ticks or actions.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import pymunk
from pymunk import autogeometry
from pymunk._chipmunk_cffi import lib

from movingout.maps.shapes import box_sides, corner_radius, outline
from movingout.maps.spec import ARENA_HALF, GOAL_MARGIN, ROBOT_RADIUS, WALL_MARGIN, ItemSpec, MapSpec, Pose, Rect
from movingout.world import constants as c
from movingout.world.drive import EMPTY_HAND, Hand


@dataclass(slots=True, eq=False)
class ItemBody:
    """An item's body. It is static unless held, and cannot be pushed."""

    index: int
    spec: ItemSpec
    body: pymunk.Body
    shapes: list[pymunk.Shape]
    handle: Any  # the engine's own body, to read poses without the wrapper


@dataclass(slots=True, eq=False)
class RobotBody:
    """A robot's body, the hidden body that steers it, and its hand."""

    body: pymunk.Body
    handle: Any
    control: Any  # the engine's own control body
    eyes: tuple[pymunk.Body, pymunk.Body]
    shapes: list[pymunk.Shape]
    turns_freely: bool = True  # the official "if_control_angle"; of interest only while it holds something
    item: ItemBody | None = None
    hand: Hand = EMPTY_HAND  # what holding means for driving; changes with a toggle of either robot
    joints: tuple[pymunk.Constraint, ...] = ()


@dataclass(slots=True, eq=False)
class Bodies:
    """All bodies of one map in one engine space."""

    space: pymunk.Space
    robots: tuple[RobotBody, RobotBody]
    items: tuple[ItemBody, ...]
    item_of_shape: dict[pymunk.Shape, ItemBody]


def build_bodies(map_spec: MapSpec) -> Bodies:
    """A new engine space that holds everything on the map."""
    space = pymunk.Space()
    space.iterations = c.SOLVER_ITERATIONS
    space.collision_slop = c.COLLISION_SLOP
    _add_arena(space)
    for goal in map_spec.goals:
        _add_goal(space, goal)
    items = tuple(_add_item(space, index, spec) for index, spec in enumerate(map_spec.items))
    blue, red = (_add_robot(space, pose) for pose in map_spec.robots)
    for wall in map_spec.walls:
        _add_wall(space, wall)
    item_of_shape = {shape: item for item in items for shape in item.shapes}
    return Bodies(space, (blue, red), items, item_of_shape)


def move_bodies(bodies: Bodies, robot_poses: Iterable[Iterable[float]], item_poses: Iterable[Iterable[float]]) -> None:
    """Put robots and items, held by nobody, somewhere else, at rest and without the engine's memory of contacts.

    What follows is not equal to the bit to what a new space does: contacts are solved in the order of the engine's
    tree, and the tree keeps its shape.
    """
    for item, pose in zip(bodies.items, item_poses, strict=True):
        item.body.body_type = pymunk.Body.STATIC
        _put(item.handle, *pose)
    for robot, pose in zip(bodies.robots, robot_poses, strict=True):
        for handle in (robot.handle, robot.control, *(eye._body for eye in robot.eyes)):
            _put(handle, *pose)
    of_items = [shape._shape for item in bodies.items for shape in item.shapes]
    shapes = of_items + [shape._shape for robot in bodies.robots for shape in robot.shapes]
    for shape in shapes:  # the engine keeps the impulses of contacts while a shape is in the space
        lib.cpSpaceRemoveShape(bodies.space._space, shape)
    for shape in shapes:
        lib.cpSpaceAddShape(bodies.space._space, shape)


def _put(handle: Any, x: float, y: float, angle: float) -> None:
    lib.cpBodySetPosition(handle, (x, y))
    lib.cpBodySetAngle(handle, angle)
    lib.cpBodySetVelocity(handle, (0.0, 0.0))
    lib.cpBodySetAngularVelocity(handle, 0.0)


def _add_arena(space: pymunk.Space) -> None:
    body = pymunk.Body(body_type=pymunk.Body.STATIC)
    far = ARENA_HALF + c.ARENA_WALL_RADIUS
    corners = [(-far, far), (far, far), (far, -far), (-far, -far)]
    edges = [
        pymunk.Segment(body, start, end, c.ARENA_WALL_RADIUS)
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    for edge in edges:
        edge.friction = c.ARENA_WALL_FRICTION
    # A sensor over the whole arena: it touches nothing but shapes the engine's tree, thus contact order. A filter that
    # spares its contacts would save a sixth of a step, but changes 10 of the 132 official trajectories.
    layer = pymunk.Poly.create_box(body, (2 * ARENA_HALF, 2 * ARENA_HALF))
    layer.sensor = True
    space.add(body, *edges, layer)


def _add_goal(space: pymunk.Space, goal: Rect) -> None:
    body = pymunk.Body(body_type=pymunk.Body.STATIC)
    body.position = ((goal.left + goal.right) / 2, (goal.bottom + goal.top) / 2)
    size = (goal.right - goal.left + 2 * GOAL_MARGIN, goal.top - goal.bottom + 2 * GOAL_MARGIN)
    sensor = pymunk.Poly.create_box(body, size)
    sensor.sensor = True
    space.add(body, sensor)


def _add_item(space: pymunk.Space, index: int, spec: ItemSpec) -> ItemBody:
    body = pymunk.Body(body_type=pymunk.Body.STATIC)  # before it enters the space: the order depends on it
    body.position = (spec.pose.x, spec.pose.y)
    body.angle = spec.pose.angle
    shapes = list(_item_shapes(body, spec))
    for shape in shapes:
        shape.friction = c.ITEM_FRICTION
        if spec.shape == "star":
            shape.filter = pymunk.ShapeFilter(group=c.STAR_GROUP + index)
    space.add(body, *shapes)
    return ItemBody(index, spec, body, shapes, body._body)


def _item_shapes(body: pymunk.Body, spec: ItemSpec) -> Iterable[pymunk.Shape]:
    if spec.shape == "circle":
        return [pymunk.Circle(body, spec.scale)]
    if spec.shape in ("square", "rectangle"):
        size = box_sides(spec.shape, spec.scale)
        return [pymunk.Poly.create_box(body, size, corner_radius(spec.shape, spec.scale))]
    vertices = list(outline(spec.shape, spec.scale))
    if spec.shape == "star":
        return [pymunk.Poly(body, part) for part in _convex_parts(spec.scale)]
    return [pymunk.Poly(body, vertices)]


@lru_cache(maxsize=256)
def _convex_parts(scale: float) -> list[list[pymunk.Vec2d]]:
    """A star of this scale in convex parts, closed lines in the engine's order.

    What `autogeometry.convex_decomposition` does, but its result is given back: the original leaks 1.7 KB a call.
    """
    vertices = outline("star", scale)
    line = autogeometry._to_chipmunk([*vertices, vertices[0]])
    parts = lib.cpPolylineConvexDecomposition(line, 0)
    try:
        return autogeometry._from_polyline_set(parts)
    finally:
        lib.cpPolylineSetFree(parts, True)


def _add_robot(space: pymunk.Space, pose: Pose) -> RobotBody:
    moment = c.ROBOT_MASS * ROBOT_RADIUS**2 / 2
    body = pymunk.Body(c.ROBOT_MASS, moment)
    control = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    eye_moment = moment * c.EYE_MASS
    eyes = pymunk.Body(c.EYE_MASS, eye_moment), pymunk.Body(c.EYE_MASS, eye_moment)
    for part in (body, control, *eyes):
        part.position = (pose.x, pose.y)
        part.angle = pose.angle
    springs = [pymunk.DampedRotarySpring(body, eye, 0, c.EYE_STIFFNESS, c.EYE_DAMPING) for eye in eyes]
    for spring in springs:
        spring.max_force = c.EYE_MAX_FORCE
    drive = pymunk.PivotJoint(control, body, (0, 0), (0, 0))
    drive.max_bias = 0  # no pull to the control body's place: it gives a velocity alone
    drive.max_force = c.DRIVE_MAX_FORCE
    turn = pymunk.GearJoint(control, body, 0, 1)
    turn.error_bias = 0  # the whole angle error in one sub-step, within the limits
    turn.max_bias = c.TURN_MAX_SPEED
    turn.max_force = c.TURN_MAX_FORCE
    circle = pymunk.Circle(body, ROBOT_RADIUS)
    circle.friction = c.ROBOT_FRICTION
    space.add(body, *springs, *eyes, control, drive, turn, circle)
    assert math.isclose(eye_moment, 0.00072)
    return RobotBody(body, body._body, control._body, eyes, [circle])


def _add_wall(space: pymunk.Space, wall: Rect) -> None:
    start, end = (wall.x0, wall.y0), (wall.x1, wall.y1)
    corner_a, corner_b = (wall.x1, wall.y0), (wall.x0, wall.y1)
    for here, there in ((start, corner_a), (start, corner_b), (end, corner_a), (end, corner_b)):
        edge = pymunk.Segment(space.static_body, here, there, WALL_MARGIN)
        edge.friction = c.WALL_FRICTION
        space.add(edge)
