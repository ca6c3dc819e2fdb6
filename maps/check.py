"""Whether a map can be played: every fault of its geometry, with its place in the JSON document and what would help.

`maps.document_check` also looks at documents that cannot be read.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any, Literal, NamedTuple

from movingout.maps.errors import DocumentFault
from movingout.maps.flood_fill import OVERLAP, overlapped
from movingout.maps.packing import fits_alone, narrowest, unplaced_items
from movingout.maps.passage import GRID, areas_near, best_near, distances_from, robot_areas, way_to_goal, window
from movingout.maps.solid import Solid, beyond_arena, item_solid, robot_solid, wall_solid
from movingout.maps.spec import ROBOT_RADIUS, SEAT_COLOURS, WALL_MARGIN, ItemSpec, MapSpec

_GRAZE = 0.0025  # items are taken this much smaller: two corners of the official HandOff graze, harmlessly
# What a terminal obeys, and what turns the letters after it around, in the title of a browser's tab, too. Marks that
# texts and emoji are written with, such as joiners, are none of these.
_CONTROLS = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
_STANDS = (0.1, 0.16)  # a robot grabs with its centre 0.12 to 0.135 from the surface; widened by half a grid step
_BESIDE = 0.19  # from a goal to a robot's centre, which does not get nearer to a corner of two walls, on the grid


FaultCode = Literal[
    "unreadable", "outside", "in_wall", "overlap", "large_unreachable", "unreachable", "no_way", "too_big",
    "goals_full", "tiny_goal", "control_characters",
]  # fmt: skip
HintCode = Literal[
    "name_taken", "name_understood", "paper_number", "degrees", "delivered", "sticks_out", "thin_wall",
    "goal_unreachable",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class MapFault:
    """Something that makes a map unplayable, or a hint: where in its JSON document, and a sentence.

    `code` and `values` say the same to programs that have sentences of their own: web/words/*.json, `fault.<code>`.
    """

    path: str
    message: str
    code: FaultCode | DocumentFault | HintCode = "unreadable"
    values: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def __str__(self) -> str:
        return f"{self.path}: {self.message}"


class _Obstacle(NamedTuple):
    path: str
    solid: Solid


def check_map(spec: MapSpec) -> tuple[MapFault, ...]:
    """All faults of a map, in the order of its document; empty when it can be played."""
    items = [_Obstacle(f"items[{index}]", item_solid(_grazing(item))) for index, item in enumerate(spec.items)]
    robots = [
        _Obstacle(f"robots.{colour}", robot_solid(pose)) for colour, pose in zip(SEAT_COLOURS, spec.robots, strict=True)
    ]
    walls = [_Obstacle(f"walls[{index}]", wall_solid(wall)) for index, wall in enumerate(spec.walls)]
    faults = [*_misplaced([*robots, *items], walls)]
    if not faults:  # where nothing stands freely, ways and reach mean nothing
        faults += _unreachable(spec)
    return (*_unprintable(spec), *faults, *_goals_without_a_cell(spec), *_too_small_goals(spec))


def _unprintable(spec: MapSpec) -> Iterator[MapFault]:
    """Others read these texts, whoever has drawn the map. Not refused in recordings, whose maps are as they were."""
    for path, text in (("title", spec.title), ("description", spec.description)):
        if _CONTROLS.search(text):
            message = "control characters, which are not seen and change what is, stand in this text; write it anew"
            yield MapFault(path, message, "control_characters")


def _grazing(item: ItemSpec) -> ItemSpec:
    return replace(item, scale=item.scale - _GRAZE)


def _misplaced(movers: list[_Obstacle], walls: list[_Obstacle]) -> Iterator[MapFault]:
    for mover in movers:
        outside = beyond_arena(mover.solid)
        if outside > 0.0:
            message = f"sticks {outside:.3f} out of the arena; move it inwards (the sides are at 1.2)"
            yield MapFault(mover.path, message, "outside", {"by": round(outside, 3)})
        for wall in walls:
            if mover.solid.gap(wall.solid) < 0.0:
                message = f"stands in {wall.path}; walls are {WALL_MARGIN:g} thicker than drawn"
                yield MapFault(mover.path, message, "in_wall", {"other": wall.path})
    for one, other in combinations(movers, 2):
        if one.solid.gap(other.solid) < 0.0:
            yield MapFault(other.path, f"overlaps {one.path}; move them apart", "overlap", {"other": one.path})


def _unreachable(spec: MapSpec) -> Iterator[MapFault]:
    ways, width = way_to_goal(spec.walls, spec.goals), 2 * ROBOT_RADIUS
    for index, item in enumerate(spec.items):
        path = f"items[{index}]"
        seats = seats_at(spec, item)
        if item.size == "large" and not all(seats):
            missing = [colour for colour, gets in zip(SEAT_COLOURS, seats, strict=True) if not gets]
            message = f"is large, but {' and '.join(missing)} cannot get to it; widen the way to more than {width}"
            yield MapFault(path, message, "large_unreachable", {"colours": missing, "width": width})
        elif not any(seats):
            message = f"no robot can get to it; widen a way to more than {width}"
            yield MapFault(path, message, "unreachable", {"width": width})
        breadth = narrowest(item.shape, item.scale)
        widest_way = 2 * best_near(ways, item.pose.x, item.pose.y)
        if widest_way < breadth:
            message = f"does not fit on any way to a goal: {breadth:.2f} broad, the way {max(widest_way, 0):.2f}"
            values = {"breadth": round(breadth, 2), "way": round(max(widest_way, 0), 2)}
            yield MapFault(path, message, "no_way", values)


def _goals_without_a_cell(spec: MapSpec) -> Iterator[MapFault]:
    """Goals to which no way leads on the grid that distances are measured on."""
    blocked, least = overlapped(spec.walls), 2 * OVERLAP
    for index, goal in enumerate(spec.goals):
        if not (overlapped([goal]) & ~blocked).any():
            message = f"is too small for distances to it; make it broader and higher than {least}, out of walls"
            yield MapFault(f"goals[{index}]", message, "tiny_goal", {"least": least})


def _too_small_goals(spec: MapSpec) -> Iterator[MapFault]:
    too_big = [index for index, item in enumerate(spec.items) if not fits_alone(item, spec)]
    for index in too_big:
        message = "is too big for every goal; enlarge one or shrink the item"
        yield MapFault(f"items[{index}]", message, "too_big")
    if not too_big and (unplaced := unplaced_items(spec)):
        names = [f"items[{index}]" for index in unplaced]
        message = f"the goals are too small for all items together: {', '.join(names)} found no place"
        yield MapFault("goals", message, "goals_full", {"items": names})


def seats_at(spec: MapSpec, item: ItemSpec) -> tuple[bool, bool]:
    """Whether blue and red get from their starts to a place beside an item; other items do not count."""
    beside = areas_beside(spec, item)
    blue, red = (not beside.isdisjoint(areas_near(spec.walls, pose.x, pose.y)) for pose in spec.robots)
    return blue, red


def areas_beside(spec: MapSpec, item: ItemSpec) -> set[int]:
    """The areas of the map from which a robot can grab the item."""
    solid = item_solid(item)
    nearest, farthest = _STANDS
    reach = max(solid.box.right - solid.box.left, solid.box.top - solid.box.bottom) + farthest
    part = window(item.pose.x, item.pose.y, reach)
    distances = solid.distances_from(GRID[part].reshape(-1, 2))
    areas = robot_areas(spec.walls)[part].reshape(-1)
    return set(areas[(distances >= nearest) & (distances <= farthest)].tolist()) - {0}


def unreachable_goals(spec: MapSpec) -> list[int]:
    """The places of the goals that no robot gets near to from its start; none where robots do not stand freely.

    Items may get there all the same: pushed, or through a way that is too narrow for robots.
    """
    reached = set[int]().union(*(areas_near(spec.walls, pose.x, pose.y) for pose in spec.robots))
    areas = robot_areas(spec.walls)
    beside = [areas[distances_from(goal) <= _BESIDE].tolist() for goal in spec.goals]
    return [index for index, some in enumerate(beside) if reached and reached.isdisjoint(some)]
