"""The steps of an official trajectory as arrays; every fault is named with its step and key.

Older files lack keys that were added later (an item's id, scale and hold, `holded_item_*`) and call the items
otherwise; what can be inferred is, and counted.
"""

import contextlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from movingout.recordings.errors import RecordingError
from movingout.recordings.official_format import ROBOTS
from movingout.world.constants import REACH
from movingout.world.state import Floats, Ints

ITEM_KEYS = ("items", "debris", "objects")
MAX_STEPS = 100_000


@dataclass(frozen=True, slots=True)
class OfficialItem:
    """What a state says of an item besides its pose; None where it says nothing."""

    id: int | None
    shape: str
    size: str
    scale: float | None


@dataclass(frozen=True, slots=True)
class OfficialSteps:
    """S steps: the states as they were written and the actions that go with them."""

    actions: Floats  # (S, 2, 3)
    robot_poses: Floats  # (S, 2, 3)
    robot_velocities: Floats  # (S, 2, 3)
    item_poses: Floats  # (S, N, 3)
    held: Ints  # (S, 2) index into the items
    inferred_holds: int  # robot-steps whose held item was not named
    items: tuple[OfficialItem, ...]
    walls: list[Any]
    goals: list[Any]


def parse(steps: Any) -> OfficialSteps:
    """The steps of a source; RecordingError names the first fault."""
    rows = _listed(_loaded(steps))
    states = [_mapping(row[1], f"step {k}: states") for k, row in enumerate(rows)]
    items = [_items(state, f"step {k}") for k, state in enumerate(states)]
    if len({len(entry) for entry in items}) != 1:
        raise RecordingError("the number of items changes within the trajectory")
    robots = [[_mapping(_get(s, name, f"step {k}"), name) for name in ROBOTS] for k, s in enumerate(states)]
    robot_poses = _array([[_pose(r, f"step {k} robot") for r in pair] for k, pair in enumerate(robots)])
    item_poses = _array([[_pose(i, f"step {k} item") for i in entry] for k, entry in enumerate(items)])
    kinds = tuple(_kind(entry) for entry in items[0])
    held, inferred = _held(robots, items, kinds, robot_poses, item_poses)
    return OfficialSteps(
        actions=_array([_actions(row[2], f"step {k}") for k, row in enumerate(rows)]),
        robot_poses=robot_poses,
        robot_velocities=_array([[_velocity(r) for r in pair] for pair in robots]),
        item_poses=item_poses,
        held=held,
        inferred_holds=inferred,
        items=kinds,
        walls=[
            wall for wall in _areas(states[0], "walls") if wall and not (isinstance(wall, list) and wall[0] is None)
        ],
        goals=_areas(states[0], "target_area"),
    )


def _loaded(steps: Any) -> Any:
    if not isinstance(steps, str):
        return steps
    try:
        return json.loads(steps)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"steps_data is not JSON: {error}") from error


def _listed(steps: Any) -> list[Any]:
    if isinstance(steps, list) and not steps:
        raise RecordingError("it has no step: nothing was played")
    if not isinstance(steps, list) or len(steps) > MAX_STEPS:
        raise RecordingError(f"a list of 1 to {MAX_STEPS} steps is needed")
    for number, row in enumerate(steps):
        if not isinstance(row, list | tuple) or len(row) != 3:
            raise RecordingError(f"step {number}: [step, states, actions] is needed")
    return steps


def _items(state: Mapping[str, Any], where: str) -> list[Mapping[str, Any]]:
    for key in ITEM_KEYS:
        if isinstance(state.get(key), list):
            return [_mapping(item, f"{where}: {key}") for item in state[key]]
    raise RecordingError(f"{where}: no list of items under {' or '.join(ITEM_KEYS)}")


def _areas(state: Mapping[str, Any], key: str) -> list[Any]:
    found = state.get(key) or []
    if not isinstance(found, list | tuple):
        raise RecordingError(f"step 0: {key}: a list is needed, not {str(found)[:60]}")
    return list(found)


def _kind(item: Mapping[str, Any]) -> OfficialItem:
    identity, scale = item.get("id"), item.get("shape_scale")
    try:
        return OfficialItem(
            id=int(identity) if identity is not None else None,
            shape=str(item.get("shape", "")),
            size=str(item.get("size", "")),
            scale=float(scale) if scale is not None else None,
        )
    except (TypeError, ValueError, OverflowError) as error:
        raise RecordingError(f"step 0: an item's id and shape_scale are numbers, not as here: {error}") from error


def _held(
    robots: list[list[Mapping[str, Any]]],
    items: list[list[Mapping[str, Any]]],
    kinds: tuple[OfficialItem, ...],
    robot_poses: Floats,
    item_poses: Floats,
) -> tuple[Ints, int]:
    """Who holds what, (S, 2), and how often it had to be inferred from the poses."""
    places: dict[float, int] = {item.id: index for index, item in enumerate(kinds) if item.id is not None}
    held = np.full((len(robots), 2), -1, dtype=np.int64)
    inferred = 0
    for step, pair in enumerate(robots):
        for seat, robot in enumerate(pair):
            if not robot.get("hold"):
                continue
            identity = robot.get("holded_item_id")
            known = places.get(identity, -1) if isinstance(identity, int | float) else -1  # a list is no key
            named = known if known >= 0 else _flagged(items[step], seat)
            if named < 0:
                named = _nearest(robot_poses[step, seat], item_poses[step])
                inferred += 1
            held[step, seat] = named
    return held, inferred


def _flagged(items: list[Mapping[str, Any]], seat: int) -> int:
    """The item whose own hold flags name the seat, -1 for none."""
    for index, item in enumerate(items):
        flags = item.get("hold")
        if isinstance(flags, list) and len(flags) == 2 and flags[seat]:
            return index
    return -1


def _nearest(robot: Floats, items: Floats) -> int:
    """The item nearest to where a robot grasps."""
    x, y, angle = robot.tolist()
    point = (x - REACH * math.sin(angle), y + REACH * math.cos(angle))
    return int(np.argmin(np.hypot(items[:, 0] - point[0], items[:, 1] - point[1])))


def _actions(value: Any, where: str) -> list[list[float]]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise RecordingError(f"{where}: two actions are needed")
    return [_numbers(action, 3, f"{where}: action") for action in value]


def _pose(body: Mapping[str, Any], where: str) -> list[float]:
    return [*_numbers(_get(body, "pos", where), 2, f"{where} pos"), *_numbers([_get(body, "angle", where)], 1, where)]


def _velocity(robot: Mapping[str, Any]) -> list[float]:
    """Velocities were added to the files later; without one the robot counts as standing still."""
    linear = _numbers(robot.get("velocity") or [0.0, 0.0], 2, "velocity")
    return [*linear, *_numbers([robot.get("angular_velocity") or 0.0], 1, "angular_velocity")]


def _numbers(value: Any, count: int, where: str) -> list[float]:
    if isinstance(value, list | tuple) and len(value) == count and all(isinstance(n, int | float) for n in value):
        with contextlib.suppress(OverflowError):  # of a whole number beyond all floats
            numbers = [float(n) for n in value]
            if all(math.isfinite(n) for n in numbers):
                return numbers
    raise RecordingError(f"{where}: {count} finite number{'s' * (count > 1)} are needed, not {str(value)[:60]}")


def _mapping(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise RecordingError(f"{where}: an object is needed, not {str(value)[:60]}")
    return value


def _get(body: Mapping[str, Any], key: str, where: str) -> Any:
    if key not in body:
        raise RecordingError(f"{where}: {key!r} is missing")
    return body[key]


def _array(rows: list[Any]) -> Floats:
    return np.array(rows, dtype=np.float64)
