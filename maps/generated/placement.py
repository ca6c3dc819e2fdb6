"""What stands on a generated map: goal regions, items in groups, robots; everything drawn until it has room."""

import math
from collections.abc import Sequence
from dataclasses import replace

from movingout.maps.generated.skeletons import ARENA, Draw, Skeleton
from movingout.maps.packing import smallest_box
from movingout.maps.shapes import circumradius, corner_radius
from movingout.maps.solid import Solid, beyond_arena, item_solid, robot_solid, wall_solid
from movingout.maps.spec import ARENA_HALF, SHAPES, ItemSpec, Mode, Pose, Rect, Size

SCALES: dict[Size, float] = {"small": 0.06, "middle": 0.11, "large": 0.17}
MASSES: dict[Size, float] = {"small": 0.1, "middle": 0.5, "large": 0.5}
_GAP = 0.02  # between any two things at the start
_FROM_GOAL = 0.15  # an item begins at least this far from every goal region
_BETWEEN_GOALS = 0.1
_TRIES = 30
_QUARTER = math.pi / 2


def draw_items(draw: Draw, mode: Mode, difficulty: int, *, small_only: bool) -> list[ItemSpec]:
    """Three to seven items without a place, the largest first."""
    sizes = ["small"] * draw.whole(3, 5 + difficulty) if small_only else _sizes(draw, mode, difficulty)
    favourite = draw.one_of(SHAPES)
    alike = draw.chance(0.25)  # some maps have one shape in all sizes, as AdaptiveAssist
    items = []
    for number, size in enumerate(sorted(sizes, key=("large", "middle", "small").index)):
        shape = favourite if alike else draw.one_of(SHAPES)
        scale = 0.2 if (size, shape) == ("large", "rectangle") else SCALES[size]  # type: ignore[index]
        angle = round(draw.length(-3.1, 3.1, 0.1), 2)
        items.append(ItemSpec(number, shape, size, scale, MASSES[size], Pose(0.0, 0.0, angle)))  # type: ignore[index, arg-type]
    return items


def _sizes(draw: Draw, mode: Mode, difficulty: int) -> list[str]:
    match mode:
        case "coordination":
            middles = draw.whole(0, difficulty)
            return ["small"] * draw.whole(3, 5 + difficulty - middles) + ["middle"] * middles
        case "awareness":
            large, middles = draw.whole(0, 1 + (difficulty > 1)), draw.whole(1, 2)
            return ["large"] * large + ["middle"] * middles + ["small"] * draw.whole(2, 3 + (large == 0))
        case _:
            large = draw.whole(2, 3)
            return ["large"] * large + [draw.one_of(("small", "middle", "large")) for _ in range(4 - large)]


def draw_goals(draw: Draw, skeleton: Skeleton, items: Sequence[ItemSpec]) -> tuple[Rect, ...] | None:
    """One to three goal regions beside the walls, with room for all items; None where none was found."""
    if skeleton.goals:
        return skeleton.goals
    count = draw.one_of((1, 1, 1, 2, 2, 3))
    boxes = [smallest_box(item.shape, item.scale) for item in items]
    area = sum((width + 0.06) * (height + 0.06) for width, height in boxes) / (draw.length(0.3, 0.55) * count)
    least = max(max(box) for box in boxes) + 0.1
    side = max(math.sqrt(area), least, 0.4)
    goals: list[Rect] = []
    for _ in range(8 * _TRIES):
        width = _snap(side * draw.one_of((0.8, 1.0, 1.0, 1.25)))
        height = _snap(max(area / width, least, 0.35))
        goal = _goal(draw, skeleton.goal_area, width, height)
        near = [other.grown(_BETWEEN_GOALS) for other in goals]
        if goal is not None and not any(_overlap(goal, other) for other in (*near, *skeleton.walls)):
            goals.append(goal)
            if len(goals) == count:
                return tuple(goals)
    return None


def _goal(draw: Draw, area: Rect, width: float, height: float) -> Rect | None:
    """A region in a corner, at an edge, in the middle or anywhere in an area."""
    free_x, free_y = area.right - area.left - width, area.top - area.bottom - height
    if free_x < 0.0 or free_y < 0.0:
        return None
    shares = {
        "corner": (draw.whole(0, 1), draw.whole(0, 1)),
        "edge": draw.one_of(((0, 0.5), (1, 0.5), (0.5, 0), (0.5, 1))),
        "middle": (0.5, 0.5),
        "anywhere": (float(draw.random.random()), float(draw.random.random())),
    }
    across, up = shares[draw.one_of(("corner", "corner", "edge", "edge", "middle", "anywhere"))]
    left, bottom = round(area.left + _down(free_x * across), 3), round(area.bottom + _down(free_y * up), 3)
    return Rect(left, bottom, round(left + width, 3), round(bottom + height, 3))


def place_items(
    draw: Draw, skeleton: Skeleton, goals: Sequence[Rect], items: Sequence[ItemSpec]
) -> list[ItemSpec] | None:
    """The items in one to three groups, each a row, a column, a block or scattered; None without room for all."""
    taken = [wall_solid(wall) for wall in skeleton.walls]
    groups = draw.whole(1, min(3, len(items)))
    placed: list[ItemSpec] = []
    order = list(items)
    draw.random.shuffle(order)
    for number in range(groups):
        group = order[number::groups]
        found = _group(draw, skeleton.item_area, goals, group, taken)
        if found is None:
            return None
        placed += found
        taken += [item_solid(item) for item in found]
    return sorted(placed, key=lambda item: item.id)


def _group(
    draw: Draw, area: Rect, goals: Sequence[Rect], group: Sequence[ItemSpec], taken: Sequence[Solid]
) -> list[ItemSpec] | None:
    pitch = 2 * max(circumradius(item.shape, item.scale) + corner_radius(item.shape, item.scale) for item in group)
    pitch = round(pitch + draw.one_of((0.04, 0.06, 0.15)), 2)
    pattern = draw.one_of(("row", "column", "block", "scatter", "scatter"))
    for _ in range(_TRIES):
        x, y = draw.length(area.left + 0.1, area.right - 0.1), draw.length(area.bottom + 0.1, area.top - 0.1)
        found: list[ItemSpec] = []
        for number, item in enumerate(group):
            column, row = {"row": (number, 0), "column": (0, number)}.get(pattern, (number % 2, number // 2))
            if pattern == "scatter" and number:
                x, y = draw.length(area.left + 0.1, area.right - 0.1), draw.length(area.bottom + 0.1, area.top - 0.1)
                column = row = 0
            pose = Pose(round(x + column * pitch, 3), round(y + row * pitch, 3), item.pose.angle)
            moved = replace(item, pose=pose)
            if not _fits(item_solid(moved), [*taken, *map(item_solid, found)], goals):
                break
            found.append(moved)
        if len(found) == len(group):
            return found
    return None


def place_robots(draw: Draw, skeleton: Skeleton, items: Sequence[ItemSpec]) -> tuple[Pose, Pose] | None:
    """Blue and red where the skeleton wants them, looking along an axis; None without room."""
    taken = [*map(wall_solid, skeleton.walls), *map(item_solid, items)]
    areas = skeleton.robot_areas if draw.chance(0.5) else skeleton.robot_areas[::-1]
    near = areas == (ARENA, ARENA) and draw.chance(0.4)  # beside each other, as on many of the paper's maps
    poses: list[Pose] = []
    for area in areas:
        if near and poses:
            x, y = poses[0].x, poses[0].y
            area = Rect(x - 0.35, y - 0.35, x + 0.35, y + 0.35)
        for _ in range(_TRIES):
            x, y = draw.length(area.left, area.right), draw.length(area.bottom, area.top)
            pose = Pose(x, y, round(draw.whole(-1, 2) * _QUARTER, 4))
            if _fits(robot_solid(pose), taken, ()):
                poses.append(pose)
                taken.append(robot_solid(pose))
                break
        else:
            return None
    return poses[0], poses[1]


def _fits(solid: Solid, taken: Sequence[Solid], goals: Sequence[Rect]) -> bool:
    if beyond_arena(solid) > -_GAP:
        return False
    around = solid.box.grown(_FROM_GOAL)
    if any(_overlap(around, goal) for goal in goals):
        return False
    return all(solid.gap(other) >= _GAP for other in taken)


def _overlap(one: Rect, other: Rect) -> bool:
    return (
        one.left < other.right - 1e-9
        and other.left < one.right - 1e-9
        and one.bottom < other.top - 1e-9
        and other.bottom < one.top - 1e-9
    )


def _snap(length: float) -> float:
    return min(round(math.ceil(length / 0.05 - 1e-9) * 0.05, 3), 2 * ARENA_HALF)


def _down(length: float) -> float:
    return math.floor(length / 0.05 + 1e-9) * 0.05
