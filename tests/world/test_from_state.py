"""Worlds that are set up from what is seen, to simulate on from there."""

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.world import World
from movingout.world.errors import WorldError
from movingout.world.state import Floats


def _played(map_name: str, actions: Floats) -> World:
    world = World(load_map(map_name), record_sub_poses=False)
    for both in actions:
        world.step(both)
    return world


def _driven(ticks: int, seed: int) -> Floats:
    """Actions (ticks, 2, 3) of two robots that drive on for a while, turn, and press now and then."""
    random = np.random.default_rng(seed)
    turns = np.repeat(random.uniform(-np.pi, np.pi, (ticks // 10, 2)), 10, axis=0)
    presses = random.random((ticks, 2)) < 0.2
    return np.stack((np.full((ticks, 2), 0.8), turns, presses), axis=-1)


@pytest.mark.parametrize(("sub_steps", "near"), [(20, 0.005), (10, 0.012)])
@pytest.mark.parametrize("map_name", ["HandOff", "AdaptiveAssist", "generated:awareness:3"])
def test_it_goes_on_nearly_as_the_world_that_was_seen(map_name: str, sub_steps: int, near: float) -> None:
    actions = _driven(200, seed=3)
    world, off = _played(map_name, actions[:0]), []
    states = [world.state()]
    for both in actions:
        world.step(both)
        states.append(world.state())
    again = World(world.map, record_sub_poses=False, sub_steps=sub_steps)
    for tick in range(0, 192, 8):
        again.place(states[tick])
        for both in actions[tick : tick + 8]:
            again.step(both)
        now, then = again.state(), states[tick + 8]
        off.append(np.abs(now.robot_poses - then.robot_poses)[:, :2].max())
    assert np.median(off) < near  # a robot drives 0.48 in eight ticks


@pytest.mark.parametrize("sub_steps", [0, 7])
def test_an_odd_number_of_engine_steps_is_refused(sub_steps: int) -> None:
    with pytest.raises(WorldError, match=f"an even number of engine steps, not {sub_steps}"):
        World(load_map("HandOff"), record_sub_poses=False, sub_steps=sub_steps)


def test_what_is_held_is_held_by_one_and_by_both() -> None:
    world = World(load_map("AdaptiveAssist"), record_sub_poses=False)
    state = world.state()
    assert World.from_state(world.map, state).state().held.tolist() == [-1, -1]
    for held in ([2, -1], [-1, 0], [1, 1]):
        seen = type(state)(
            state.tick, state.robot_poses, state.robot_velocities, np.array(held, dtype=np.int64), state.item_poses
        )
        again = World.from_state(world.map, seen)
        assert again.state().held.tolist() == held
        again.step([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
        assert again.state().held.tolist() == held


def test_the_same_state_gives_the_same_floats() -> None:
    world = _played("HandOff", _driven(60, seed=5))
    rows = []
    for _ in range(2):
        again = World.from_state(world.map, world.state())
        again.step([[1.0, 0.3, 1.0], [-1.0, 2.0, 0.0]])
        rows.append(again.state().robot_poses)
    assert np.array_equal(rows[0], rows[1])
    assert np.array_equal(again.state().item_poses.shape, world.state().item_poses.shape)


@pytest.mark.parametrize("map_name", ["HandOff", "AdaptiveAssist", "SingleRotation"])
def test_a_world_that_is_placed_again_and_again_goes_on_as_a_new_one(map_name: str) -> None:
    actions = _driven(160, seed=7)
    world, states, off = _played(map_name, actions[:0]), [], []
    for both in actions:
        states.append(world.state())
        world.step(both)
    used = World.from_state(world.map, states[0])
    for tick in range(0, 152, 8):
        used.place(states[tick])
        assert np.array_equal(used.state().robot_poses, states[tick].robot_poses)
        assert np.array_equal(used.state().item_poses, states[tick].item_poses)
        assert used.state().held.tolist() == states[tick].held.tolist() and used.tick == 0
        new = World.from_state(world.map, states[tick])
        for both in actions[tick : tick + 8]:
            new.step(both)
            used.step(both)
        assert new.state().held.tolist() == used.state().held.tolist()
        off.append(np.abs(new.state().robot_poses - used.state().robot_poses)[:, :2].max())
    assert np.median(off) < 0.002  # less than either is off from the world that was seen
