"""What the tests of the world share: the official recordings as our states, and states made by hand."""

from functools import lru_cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec, load_map
from movingout.world.state import WorldState
from tests.support import REFERENCE

OFFICIAL_FILES = sorted((REFERENCE / "golden").glob("*.npz"))


@lru_cache(maxsize=4)
def official_arrays(path: Path) -> dict[str, npt.NDArray[np.generic]]:
    return dict(np.load(path))


def official_states(path: Path) -> tuple[MapSpec, list[WorldState]]:
    """The map and the T + 1 states of an official recording."""
    official = official_arrays(path)
    map_spec = load_map(str(official["map_name"]))
    places = {item.id: index for index, item in enumerate(map_spec.items)} | {-1: -1}
    held = np.vectorize(places.__getitem__, otypes=[np.int64])(official["held_id"])
    robots = with_angle(official["robot_pos"], official["robot_angle"])
    velocities = with_angle(official["robot_vel"], official["robot_angvel"])
    items = with_angle(official["item_pos"], official["item_angle"])
    return map_spec, [WorldState(t, robots[t], velocities[t], held[t], items[t]) for t in range(len(robots))]


def with_angle(points: npt.NDArray[np.generic], angles: npt.NDArray[np.generic]) -> npt.NDArray[np.float64]:
    """(..., 2) and (...) as (..., 3)."""
    return np.concatenate((points, angles[..., None]), axis=-1).astype(np.float64)


def start_of(map_spec: MapSpec) -> WorldState:
    """The state at tick 0."""
    return WorldState(
        tick=0,
        robot_poses=np.array([(pose.x, pose.y, pose.angle) for pose in map_spec.robots]),
        robot_velocities=np.zeros((2, 3)),
        held=np.array([-1, -1]),
        item_poses=np.array([(item.pose.x, item.pose.y, item.pose.angle) for item in map_spec.items]),
    )


def changed(
    state: WorldState,
    held: tuple[int, int] | None = None,
    robots: dict[int, tuple[float, float, float]] | None = None,
    items: dict[int, tuple[float, float, float]] | None = None,
) -> WorldState:
    """The next state: the same but for what is given."""
    robot_poses, item_poses = state.robot_poses.copy(), state.item_poses.copy()
    for index, pose in (robots or {}).items():
        robot_poses[index] = pose
    for index, pose in (items or {}).items():
        item_poses[index] = pose
    hands = state.held if held is None else np.array(held)
    return WorldState(state.tick + 1, robot_poses, state.robot_velocities, hands, item_poses)
