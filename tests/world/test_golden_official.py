"""The official environment's trajectories, replayed to the bit. The data is not part of the repository."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from movingout.maps import load_map
from movingout.world import World
from tests.support import REFERENCE, reference

FILES = sorted((REFERENCE / "golden").glob("*.npz"))

Arrays = dict[str, npt.NDArray[np.generic]]


def replayed(map_name: str, actions: npt.NDArray[np.float64]) -> Arrays:
    """Every state of our world under the actions, under the names of the reference files."""
    world = World(load_map(map_name))
    ids = np.array([item.id for item in world.map.items] + [-1])
    states, delivered, scores = [world.state()], [world.delivered()], [world.score()]
    for action in actions:
        world.step(action)
        states.append(world.state())
        delivered.append(world.delivered())
        scores.append(world.score())
    robots = np.array([state.robot_poses for state in states])
    velocities = np.array([state.robot_velocities for state in states])
    items = np.array([state.item_poses for state in states])
    return {
        "robot_pos": robots[:, :, :2],
        "robot_angle": robots[:, :, 2],
        "robot_vel": velocities[:, :, :2],
        "robot_angvel": velocities[:, :, 2],
        "item_pos": items[:, :, :2],
        "item_angle": items[:, :, 2],
        "held_id": ids[np.array([state.held for state in states])],
        "delivered": np.array(delivered),
        "score": np.array(scores),
    }


def first_difference(ours: Arrays, official: Arrays) -> str:
    """Empty when all arrays are equal to the bit, else the earliest tick that differs and in what."""
    ticks = {}
    for name, values in ours.items():
        differs = np.flatnonzero((values != official[name]).reshape(len(values), -1).any(axis=1))
        if len(differs):
            ticks[name] = int(differs[0])
    return ", ".join(f"{name} from tick {tick}" for name, tick in sorted(ticks.items(), key=lambda pair: pair[1]))


def test_all_official_trajectories_are_there() -> None:
    assert len(list(reference("golden").glob("*.npz"))) == 132


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_official_trajectory_replays_bit_for_bit(path: Path) -> None:
    official = dict(np.load(path))
    ours = replayed(str(official["map_name"]), official["actions"])
    assert first_difference(ours, official) == ""
