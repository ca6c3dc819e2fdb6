"""Which of our maps a trajectory was played on, and how its first state differs from that map as designed."""

import contextlib
from collections.abc import Iterable, Sequence
from dataclasses import astuple, replace
from typing import Any, cast, get_args

from movingout.maps import MapSpec, Pose, Rect, load_map, map_names
from movingout.maps.errors import MapError
from movingout.maps.json_format import map_from_json, map_to_json
from movingout.maps.spec import ItemSpec, Shape, Size
from movingout.recordings.errors import RecordingError
from movingout.recordings.imports.sources import TrajectoryFile
from movingout.recordings.imports.steps import OfficialItem, OfficialSteps
from movingout.recordings.storage import copies

# The official environment's old numbers: 1000-1003 are the paper's maps 1-4, 2000-2007 its maps 5-12.
OLD_NUMBERS = dict(zip([*range(1000, 1004), *range(2000, 2008)], map_names(), strict=False))
SAME = 1e-9  # arena units or rad; below it a pose is as designed
HAIR = copies.ROUNDED  # a start that is no farther away is still that of the map as designed
ROUNDED = 1e-6  # of corners, scales and masses, which other programs may have rounded, or kept in single precision
_MASSES: dict[str, float] = {"small": 0.1, "middle": 0.5, "large": 0.5}  # of the official maps


def official_map(name: Any) -> MapSpec:
    """The map of an official name or old number. Raises RecordingError."""
    text = str(name)
    known = next((name for number, name in OLD_NUMBERS.items() if text == str(number)), text)
    if known not in (*map_names(), "Simple", "simple"):
        raise RecordingError(f"unknown map {text!r}; known: {', '.join(map_names())}, Simple, 1000-1003, 2000-2007")
    return load_map(known.capitalize() if known == "simple" else known)


def maps_of(sources: Iterable[TrajectoryFile]) -> set[str]:
    """The names of the maps that trajectories were played on; names that are not known are left out."""
    found = set()
    for source in sources:
        with contextlib.suppress(RecordingError):
            found.add(official_map(source.map_name).name)
    return found


def played_map(
    designed: MapSpec, steps: OfficialSteps, starts: bool, masses: Sequence[float] = ()
) -> tuple[MapSpec, list[str]]:
    """The map as the first state shows it, and what differs from the map as designed.

    It is varied, a map of Challenge 2, unless `is_as_designed`. `starts` says that the first state is the one before
    any action; otherwise poses cannot be told from it. `masses` are those of the items where the file says them; else
    they are as designed. Raises RecordingError for a state that is no valid map.
    """
    items = [_item(designed, index, item) for index, item in enumerate(steps.items)]
    if len(masses) == len(items):
        items = [replace(item, mass=mass) for item, mass in zip(items, masses, strict=True)]
    found = replace(designed, items=tuple(items), walls=_rects(steps.walls), goals=_rects(steps.goals))
    if starts:
        poses = [Pose(*row) for row in steps.item_poses[0].tolist()]
        found = replace(
            found,
            robots=(Pose(*steps.robot_poses[0, 0].tolist()), Pose(*steps.robot_poses[0, 1].tolist())),
            items=tuple(replace(item, pose=pose) for item, pose in zip(items, poses, strict=True)),
        )
    differences = _differences(designed, found)
    if not differences:
        return designed, []
    if is_as_designed(designed, found):
        return found, differences
    try:
        return map_from_json(map_to_json(replace(found, variant="imported"))), differences
    except MapError as error:
        raise RecordingError(f"its first state is not a valid map: {error}") from error


def is_as_designed(designed: MapSpec, found: MapSpec) -> bool:
    """Whether a map is the one that was designed, but for a hair: rounded numbers, or its walls in another order."""
    same_items = [(one.id, one.shape, one.size) for one in found.items] == [
        (one.id, one.shape, one.size) for one in designed.items
    ]
    if not same_items:
        return False
    sizes = zip(_sizes(designed), _sizes(found), strict=True)
    return (
        _same_rects(designed.walls, found.walls)
        and _same_rects(designed.goals, found.goals)
        and all(abs(one - other) < ROUNDED for one, other in sizes)
        and all(_near(one, other, HAIR) for one, other in zip(_poses(designed), _poses(found), strict=True))
    )


def _same_rects(some: Sequence[Rect], others: Sequence[Rect]) -> bool:
    return len(some) == len(others) and all(
        abs(one - other) < ROUNDED
        for rect, like in zip(sorted(map(astuple, some)), sorted(map(astuple, others)), strict=True)
        for one, other in zip(rect, like, strict=True)
    )


def _sizes(the_map: MapSpec) -> list[float]:
    return [number for item in the_map.items for number in (item.scale, item.mass)]


def _poses(the_map: MapSpec) -> list[Pose]:
    return [*the_map.robots, *(item.pose for item in the_map.items)]


def _item(designed: MapSpec, index: int, item: OfficialItem) -> ItemSpec:
    """The designed item of the same id (or place), with what the state says about it."""
    same = [spec for spec in designed.items if spec.id == item.id]
    if not same and item.id is None and index < len(designed.items):
        same = [designed.items[index]]
    shape = item.shape or (same[0].shape if same else "")
    size = item.size or (same[0].size if same else "")
    if shape not in get_args(Shape) or size not in get_args(Size):
        raise RecordingError(f"item {index} has shape {shape!r} and size {size!r}, which are unknown")
    if not same and item.scale is None:
        raise RecordingError(f"item {index} is not on the map {designed.name} and has no shape_scale")
    return ItemSpec(
        id=item.id if item.id is not None else same[0].id if same else index,
        shape=cast(Shape, shape),
        size=cast(Size, size),
        scale=item.scale if item.scale is not None else same[0].scale,
        mass=same[0].mass if same else _MASSES[size],
        pose=same[0].pose if same else Pose(0.0, 0.0, 0.0),
    )


def _rects(corners: list[Any]) -> tuple[Rect, ...]:
    try:
        return tuple(Rect(float(a[0]), float(a[1]), float(b[0]), float(b[1])) for a, b in corners)
    except (TypeError, ValueError, IndexError, KeyError, OverflowError) as error:
        raise RecordingError("walls and target_area are lists of two corners each") from error


def _differences(designed: MapSpec, found: MapSpec) -> list[str]:
    differences = [name for name in ("walls", "goals") if getattr(designed, name) != getattr(found, name)]
    for colour, one, other in zip(("blue", "red"), designed.robots, found.robots, strict=True):
        if not _near(one, other):
            differences.append(f"start of {colour}")
    if len(designed.items) != len(found.items):
        return [*differences, f"{len(found.items)} items instead of {len(designed.items)}"]
    for one_item, other_item in zip(designed.items, found.items, strict=True):
        if one_item != replace(other_item, pose=one_item.pose):
            differences.append(f"kind of item {one_item.id}")
        elif not _near(one_item.pose, other_item.pose):
            differences.append(f"pose of item {one_item.id}")
    return differences


def _near(one: Pose, other: Pose, distance: float = SAME) -> bool:
    return max(abs(one.x - other.x), abs(one.y - other.y), abs(one.angle - other.angle)) < distance
