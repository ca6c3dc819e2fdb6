"""Pieces of two episodes put together, and the engine's word on them."""

from dataclasses import replace

import numpy as np
import pytest

from agents.bass.recombination import LENGTH, Piece, augmentation, find_pieces, recombined
from agents.bass.restaging import restage
from agents.dataset import Trajectory
from maps import load_map
from tests.agents.learning import states_of, trajectory_of_actions
from world.errors import WorldError


def _straight(blue: float, red: float, ticks: int = 20) -> Trajectory:
    """Both drive ahead with these distances, without turning."""
    the_map = load_map("FourCorners")
    actions = np.zeros((ticks, 2, 3))
    actions[:, :, 0] = blue, red
    actions[:, :, 1] = [pose.angle for pose in the_map.robots]
    return trajectory_of_actions(the_map, actions)


def test_a_piece_keeps_ones_own_motion_and_takes_the_partners_from_the_other_episode() -> None:
    walks = [_straight(0.2, 0.1), _straight(0.2, -0.1)]
    piece = Piece(own=0, start=2, other=1, other_start=2, seat=0)
    walk = recombined(walks, piece)
    assert walk is not None and walk.ticks == LENGTH
    assert np.allclose(walk.robot_poses[:, 0], walks[0].robot_poses[2 : 3 + LENGTH, 0], atol=0.02)
    assert np.allclose(walk.robot_poses[:, 1], walks[1].robot_poses[2 : 3 + LENGTH, 1], atol=0.02)
    assert np.array_equal(walk.actions[:, 0], walks[0].actions[2 : 2 + LENGTH, 0])
    assert np.array_equal(walk.actions[:, 1], walks[1].actions[2 : 2 + LENGTH, 1])


def test_pieces_are_found_only_where_both_ends_match() -> None:
    slow, fast = _straight(0.2, 0.1), _straight(0.9, 0.1)
    assert not any(piece.seat == 0 for piece in find_pieces([slow, fast], 0) if piece.start == 0)
    same = list(find_pieces([slow, _straight(0.2, -0.1)], 0))
    assert Piece(0, 5, 1, 5, 0) in same
    assert all(piece.own != piece.other for piece in same)
    single = list(find_pieces([slow, fast], 0, "one end"))
    assert Piece(0, 0, 1, 0, 0) in single


def test_the_engine_refuses_a_partner_who_stands_where_one_drives() -> None:
    walks = [_straight(0.2, 0.0), _straight(0.2, 0.0)]
    blocked = walks[1].robot_poses.copy()
    ahead = walks[0].robot_poses[2, 0]
    blocked[:, 1, :2] = ahead[:2] + 0.2 * np.array([-np.sin(ahead[2]), np.cos(ahead[2])])
    walks[1] = replace(walks[1], robot_poses=blocked)
    fast = [replace(walk, actions=walk.actions * (5, 1, 1)) for walk in walks]
    assert recombined(fast, Piece(0, 2, 1, 2, 0)) is None


def test_augmentation_reports_how_many_pieces_were_valid() -> None:
    walks = [_straight(0.2, speed) for speed in (0.1, 0.05, -0.1)]
    found, report = augmentation(walks, count=10, seed=1)
    assert len(found) == report.valid == 10
    assert report.share > 0.9


def test_a_restaged_world_goes_on_nearly_as_the_real_one() -> None:
    walk = _straight(0.5, 0.5, ticks=12)
    states = states_of(walk.map, walk.actions)
    world = restage(walk.map, states[4])
    for action in walk.actions[4:]:
        world.step(action)
    assert np.allclose(world.state().robot_poses, states[12].robot_poses, atol=0.03)


def test_a_hand_that_cannot_reach_is_told() -> None:
    walk = _straight(0.0, 0.0, ticks=2)
    state = states_of(walk.map, walk.actions)[1]
    state.held[0] = 3
    with pytest.raises(WorldError, match="cannot be staged anew"):
        restage(walk.map, state)
