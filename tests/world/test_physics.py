"""What World promises beside the physics itself: determinism, sub-poses, snapshots, refusals."""

import copy
import pickle
from collections.abc import Callable
from dataclasses import astuple

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.world import ActionError, World, WorldError, WorldState
from tests.world.carries import HOLDS
from tests.world.support import CIRCLE

STILL = np.zeros((2, 3))


def identical(a: WorldState, b: WorldState) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(astuple(a), astuple(b), strict=True))


def test_same_actions_give_the_same_floats() -> None:
    worlds = [World(load_map("CornerDecision")) for _ in range(2)]
    for actions in np.random.default_rng(3).uniform(-1, 1, (200, 2, 3)):
        for world in worlds:
            world.step(actions)
    assert identical(worlds[0].state(), worlds[1].state())


def test_a_state_is_a_copy() -> None:
    world = World(load_map("HandOff"))
    before = world.state()
    before.item_poses[:] = 9.0
    assert world.state().item_poses.max() < 2.0


def test_recording_sub_poses_does_not_change_the_physics() -> None:
    with_poses, without = World(load_map("LeftRight")), World(load_map("LeftRight"), record_sub_poses=False)
    for actions in HOLDS["large with two"]().actions:
        with_poses.step(actions)
        without.step(actions)
    assert identical(with_poses.state(), without.state())


def test_sub_poses_end_with_the_state_and_are_20_ms_apart() -> None:
    world = World(load_map("DistancePriority"))
    world.step([[1, 0, 0], [1, 0, 0]])
    for _ in range(3):
        world.step([[1, 0, 0], [0, 0, 0]])
    poses, state = world.sub_poses(), world.state()
    assert poses.shape == (5, 2 + 4, 3)
    assert np.array_equal(poses[-1], np.vstack([state.robot_poses, state.item_poses]))
    assert np.allclose(np.diff(poses[:, 0, 1]), 0.6 * 0.02)  # full speed for 20 ms


def test_sub_poses_of_a_fresh_world_are_the_start() -> None:
    world = World(load_map("Simple"))
    state = world.state()
    assert (world.sub_poses() == np.vstack([state.robot_poses, state.item_poses])).all()


def test_sub_poses_follow_a_carried_item_until_it_is_let_go() -> None:
    world, row = HOLDS["small"]().world, 2 + CIRCLE
    assert (np.diff(world.sub_poses()[:, row, :2], axis=0) != 0).any(axis=1).all()
    world.step([[0, 0, 0], [1, 0.7, 1]])  # red lets go in the middle of the tick
    poses = world.sub_poses()[:, row]
    assert (np.diff(poses[:2], axis=0) != 0).any()
    assert (np.diff(poses[2:], axis=0) == 0).all()


def test_sub_poses_that_were_not_recorded_are_refused() -> None:
    world = World(load_map("Simple"), record_sub_poses=False)
    with pytest.raises(WorldError, match="record_sub_poses=True"):
        world.sub_poses()


@pytest.mark.parametrize("kind", HOLDS)
def test_restore_is_exact_while_items_are_held(kind: str) -> None:
    script = HOLDS[kind]()
    world, later = script.world, np.random.default_rng(5).uniform(-1, 1, (60, 2, 3))
    later[:, :, 2] = later[:, :, 2] > 0.9
    assert (world.state().held >= 0).sum() == (2 if "two" in kind else 1)
    snapshot = pickle.loads(pickle.dumps(world.snapshot()))
    futures = []
    for other in (world, world, World(world.map)):
        other.restore(snapshot)
        assert other.tick == snapshot.tick == len(script.actions)
        for actions in later:
            other.step(actions)
        futures.append((other.state(), other.sub_poses(), other.delivered()))
    for state, poses, delivered in futures[1:]:
        assert identical(state, futures[0][0])
        assert np.array_equal(poses, futures[0][1])
        assert np.array_equal(delivered, futures[0][2])


def test_restoring_ahead_continues_instead_of_starting_over() -> None:
    world, ahead = World(load_map("Simple")), World(load_map("Simple"))
    world.step(STILL)
    bodies = world._bodies
    for _ in range(3):
        ahead.step(STILL)
    world.restore(ahead.snapshot())
    assert world.tick == 3
    assert world._bodies is bodies


def test_a_snapshot_of_another_map_is_refused() -> None:
    with pytest.raises(WorldError, match=r"of map 'HandOff', this world of 'Simple'"):
        World(load_map("Simple")).restore(World(load_map("HandOff")).snapshot())


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        (np.zeros((2, 4)), r"got shape \(2, 4\)"),
        ([[0, 0], [0, 0, 0]], "distance, heading, grasp"),
        ([["fast", 0, 0], [0, 0, 0]], "distance, heading, grasp"),
        ([[0, 0, 0], [0, np.nan, 0]], "red's action .* not finite"),
        ([[np.inf, 0, 0], [0, 0, 0]], "blue's action .* not finite"),
    ],
)
def test_a_wrong_action_is_refused_and_changes_nothing(actions: object, message: str) -> None:
    world = World(load_map("Simple"))
    with pytest.raises(ActionError, match=message):
        world.step(actions)  # type: ignore[arg-type]
    assert identical(world.state(), World(load_map("Simple")).state())
    world.step(STILL)
    assert world.tick == 1


def test_lost_numbers_end_the_world_with_its_last_good_state() -> None:
    world = World(load_map("Simple"))
    world.step(STILL)
    before, snapshot = world.state(), world.snapshot()
    world._bodies.robots[1].body.velocity = (float("nan"), 0.0)
    with pytest.raises(WorldError, match=r"lost its numbers in tick 2 .*red at nan"):
        world.step([[0, 0, 0], [0.5, 0, 0]])
    assert identical(world.state(), before)
    assert np.isfinite(world.sub_poses()).all()
    with pytest.raises(WorldError, match="failed in an earlier step"):
        world.step(STILL)
    world.restore(snapshot)
    world.step(STILL)
    assert world.tick == 2


def test_the_name_of_a_map_makes_no_world() -> None:
    with pytest.raises(WorldError, match=r"World\(load_map\(.*, not of 'HandOff'"):
        World("HandOff")  # type: ignore[arg-type]


@pytest.mark.parametrize("copied", [copy.deepcopy, copy.copy, pickle.dumps])
def test_a_world_that_is_to_be_copied_names_the_snapshot_instead(copied: Callable[[World], object]) -> None:
    with pytest.raises(WorldError, match=r"not copied or pickled; keep its snapshot\(\), and restore\(\) it"):
        copied(World(load_map("HandOff")))
