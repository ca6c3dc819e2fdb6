"""The physics on mirrored and turned maps: what happens there is what happens on the map, moved in the same way."""

import numpy as np
import pytest

from movingout.agents.base import Agent
from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import rollout
from movingout.maps import load_map
from movingout.maps.symmetry import ALL_SYMMETRIES, Symmetry, transformed
from movingout.world import World
from movingout.world.state import WorldState

NAMES = ("HandOff", "FourCorners", "Simple")


def moved(state: WorldState, symmetry: Symmetry) -> list[tuple[float, float, float, float]]:
    """Robots and items as (x, y, cos, sin) after a symmetry."""
    rows = []
    for x, y, angle in (*state.robot_poses, *state.item_poses):
        turned = symmetry.angle(float(angle))
        rows.append((*symmetry.point(float(x), float(y)), float(np.cos(turned)), float(np.sin(turned))))
    return rows


def played(world: World, actions: list[list[float]], ticks: int) -> WorldState:
    for _ in range(ticks):
        world.step(actions)
    return world.state()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("symmetry", ALL_SYMMETRIES[1:], ids=lambda symmetry: "-".join(symmetry.names))
def test_an_idle_world_stays_what_it_is(name: str, symmetry: Symmetry) -> None:
    plain, idle = load_map(name), [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    here, there = World(plain), World(transformed(plain, symmetry))
    assert np.allclose(moved(here.state(), symmetry), moved(there.state(), Symmetry()), atol=1e-12)
    assert np.allclose(moved(played(here, idle, 20), symmetry), moved(played(there, idle, 20), Symmetry()), atol=1e-6)
    assert here.delivered().tolist() == there.delivered().tolist()


@pytest.mark.parametrize("symmetry", ALL_SYMMETRIES[1:], ids=lambda symmetry: "-".join(symmetry.names))
def test_robots_that_drive_in_the_moved_direction_come_to_the_moved_place(symmetry: Symmetry) -> None:
    plain = load_map("Simple")
    drive = [[1.0, 0.7, 0.0], [0.5, -1.2, 0.0]]
    turned = [[distance, symmetry.angle(heading), grab] for distance, heading, grab in drive]
    here, there = played(World(plain), drive, 10), played(World(transformed(plain, symmetry)), turned, 10)
    assert np.allclose(moved(here, symmetry), moved(there, Symmetry()), atol=1e-6)
    velocities = [symmetry.point(float(vx), float(vy)) for vx, vy in here.robot_velocities[:, :2]]
    assert np.allclose(velocities, there.robot_velocities[:, :2], atol=1e-6)


@pytest.mark.parametrize("name", ["HandOff:mirror", "SingleRotation:rot90"])
def test_a_scripted_pair_delivers_everything_on_a_moved_map(name: str) -> None:
    pair: tuple[Agent, Agent] = (load_agent("scripted"), load_agent("scripted"))
    steps = list(rollout(load_map(name), pair, seed=0, ticks=500))
    assert len(steps) < 500
