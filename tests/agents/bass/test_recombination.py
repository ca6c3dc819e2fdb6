"""Pieces of two episodes put together, and the engine's word on them."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from movingout.agents.bass.recombination import (
    LENGTH,
    LearnedPart,
    RecombinedPiece,
    augmentation,
    draw_pieces,
    recombined,
    spliced,
)
from movingout.agents.bass.restored_world import restage
from movingout.agents.data.dataset import SeatSamples, Trajectory, windows_of
from movingout.maps import load_map
from movingout.world.errors import WorldError
from tests.agents.learning import states_of, trajectory_of_actions


def _straight(blue: float, red: float, ticks: int = 20) -> Trajectory:
    """Both drive ahead with these distances, without turning."""
    the_map = load_map("FourCorners")
    actions = np.zeros((ticks, 2, 3))
    actions[:, :, 0] = blue, red
    actions[:, :, 1] = [pose.angle for pose in the_map.robots]
    return trajectory_of_actions(the_map, actions)


def _part(trajectory: Trajectory, seat: int = 0, *stretches: tuple[int, int]) -> LearnedPart:
    """What the seat did is to be learned; in all ticks, if no stretches are given."""
    return LearnedPart(trajectory, seat, trajectory.targets(seat, "hold"), stretches or ((0, trajectory.ticks),))


def test_a_piece_keeps_ones_own_motion_and_takes_the_partners_from_the_other_episode() -> None:
    trajectories = [_straight(0.2, 0.1), _straight(0.2, -0.1)]
    trajectory = recombined(RecombinedPiece(_part(trajectories[0]), 2, trajectories[1], 2))
    assert trajectory is not None and trajectory.ticks == LENGTH
    assert np.allclose(trajectory.robot_poses[:, 0], trajectories[0].robot_poses[2 : 3 + LENGTH, 0], atol=0.02)
    assert np.allclose(trajectory.robot_poses[:, 1], trajectories[1].robot_poses[2 : 3 + LENGTH, 1], atol=0.02)
    assert np.array_equal(trajectory.actions[:, 0], trajectories[0].actions[2 : 2 + LENGTH, 0])
    assert np.array_equal(trajectory.actions[:, 1], trajectories[1].actions[2 : 2 + LENGTH, 1])
    assert np.array_equal(trajectory.robot_velocities[0, 0], trajectories[0].robot_velocities[2, 0])
    assert np.array_equal(trajectory.robot_velocities[0, 1], trajectories[1].robot_velocities[2, 1])


def _starts(pieces: Iterable[RecombinedPiece]) -> set[int]:
    return {piece.start for piece in pieces}


def test_pieces_are_found_only_where_both_ends_match() -> None:
    slow, fast = _straight(0.2, 0.1), _straight(0.9, 0.1)
    assert 0 not in _starts(draw_pieces([_part(slow), _part(fast)], seed=1))
    assert 0 in _starts(draw_pieces([_part(slow), _part(fast)], 1, "one-end"))
    same = list(draw_pieces([_part(slow), _part(_straight(0.2, -0.1))], seed=1))
    assert len(same) == 2 * (slow.ticks - LENGTH + 1)
    assert all(piece.own.trajectory is not piece.other for piece in same)


def test_the_single_agent_ablation_matches_either_end() -> None:
    first, second = _straight(0.2, 0.1), _straight(0.2, -0.1)
    faster = replace(second, robot_poses=second.robot_poses + np.arange(len(second.robot_poses))[:, None, None] * 0.05)
    assert not any(piece.own.trajectory is first for piece in draw_pieces([_part(first), _part(faster)], seed=1))
    starts = _starts(draw_pieces([_part(first), _part(faster)], 1, "either-end"))
    assert 0 in starts, "they begin in the same place"
    ends = replace(faster, robot_poses=faster.robot_poses + first.robot_poses[-1] - faster.robot_poses[-1])
    assert first.ticks - LENGTH in _starts(draw_pieces([_part(first), _part(ends)], 1, "either-end"))
    assert first.ticks - LENGTH not in _starts(draw_pieces([_part(first), _part(ends)], 1, "one-end"))


def test_variants_of_a_map_share_their_ground_and_keep_their_own_items() -> None:
    first, second = _variant(_straight(0.2, 0.1), 1.0), _variant(_straight(0.2, -0.1), 2.0)
    elsewhere = replace(second, map=replace(second.map, goals=second.map.goals[:-1]))
    assert list(draw_pieces([_part(first), _part(elsewhere)], seed=1)) == []
    pieces = [piece for piece in draw_pieces([_part(first), _part(second)], seed=1) if piece.own.trajectory is second]
    assert len(pieces) == second.ticks - LENGTH + 1
    made = recombined(pieces[0])
    assert made is not None and made.map == second.map


def _variant(trajectory: Trajectory, mass: float) -> Trajectory:
    items = tuple(replace(item, mass=mass * item.mass) for item in trajectory.map.items)
    return replace(trajectory, map=replace(trajectory.map, items=items, variant=f"challenge2-train-{mass}"))


def test_without_the_engine_pieces_are_put_together_unseen_and_the_report_still_says_what_is_possible() -> None:
    trajectories = [_straight(0.2, 0.1), _straight(0.2, -0.1)]
    far = np.zeros_like(trajectories[1].robot_poses)
    far[:, 1, 0] = 0.5  # the partner is somewhere that its actions do not lead to
    moved = replace(trajectories[1], robot_poses=trajectories[1].robot_poses + far)
    moved.robot_poses[LENGTH:, 1, 1] += 0.5
    piece = RecombinedPiece(_part(trajectories[0]), 2, moved, 2)
    assert recombined(piece) is None
    made = spliced(piece)
    assert made is not None
    assert np.array_equal(made.robot_poses[:, 0], trajectories[0].robot_poses[2 : 3 + LENGTH, 0])
    assert np.array_equal(made.robot_poses[:, 1], moved.robot_poses[2 : 3 + LENGTH, 1])
    parts = [_part(trajectories[0]), _part(trajectories[1])]
    found, report = augmentation(parts, 3, seed=0, confirm=False)
    assert len(found) == 3 and report.tried == 3 and report.valid == 3


def test_a_match_may_be_at_any_tick_and_in_whichever_seat_the_other_episode_is_learned() -> None:
    own, other = _straight(0.2, 0.1), _straight(0.2, -0.1, ticks=30)
    parts = [_part(own, 0, (3, 12)), _part(other, 1, (0, 4))]
    pieces = list(draw_pieces(parts, seed=1))
    assert _starts(pieces) == {3, 4} and all(piece.other is other for piece in pieces)
    assert all(np.array_equal(piece.targets, own.targets(0, "hold")[piece.start : 12]) for piece in pieces)


def test_what_one_did_after_a_piece_is_in_the_chunks_of_its_last_ticks() -> None:
    own = _straight(0.2, 0.1, ticks=40)
    (piece, *_) = (one for one in draw_pieces([_part(own), _part(_straight(0.2, -0.1))], 1) if one.start == 2)
    features = np.zeros((LENGTH, 4), np.float32)
    windows = windows_of([SeatSamples("a", features, piece.targets), SeatSamples("b", features[:3], piece.targets[:3])])
    assert len(windows) == LENGTH + 3
    targets, last = own.targets(0, "hold"), 2 + LENGTH - 1
    chunks = windows.chunks(np.array([LENGTH - 1, LENGTH + 1]), LENGTH)
    assert np.array_equal(chunks[0], targets[last : last + LENGTH])
    assert np.array_equal(chunks[1], targets[[3, *(LENGTH - 1) * [4]]])


def test_episodes_of_different_maps_are_not_put_together() -> None:
    trajectory = _straight(0.2, 0.1)
    elsewhere = replace(trajectory, map=replace(trajectory.map, items=trajectory.map.items[::-1]))
    assert not list(draw_pieces([_part(trajectory), _part(elsewhere)], seed=1))


def test_the_engine_refuses_a_partner_who_stands_where_one_drives() -> None:
    trajectories = [_straight(0.2, 0.0), _straight(0.2, 0.0)]
    blocked = trajectories[1].robot_poses.copy()
    ahead = trajectories[0].robot_poses[2, 0]
    blocked[:, 1, :2] = ahead[:2] + 0.2 * np.array([-np.sin(ahead[2]), np.cos(ahead[2])])
    trajectories[1] = replace(trajectories[1], robot_poses=blocked)
    own, other = (replace(trajectory, actions=trajectory.actions * (5, 1, 1)) for trajectory in trajectories)
    assert recombined(RecombinedPiece(_part(own), 2, other, 2)) is None


def test_augmentation_reports_how_many_pieces_were_valid_and_finds_the_same_from_the_same_seed() -> None:
    parts = [_part(_straight(0.2, speed), seat) for speed in (0.1, 0.05, -0.1) for seat in (0, 1)]
    found, report = augmentation(parts, count=10, seed=1)
    assert len(found) == report.valid == 10
    assert report.share > 0.9
    again, other = (augmentation(parts, count=10, seed=seed)[0] for seed in (1, 2))
    assert [piece.start for piece, _ in again] == [piece.start for piece, _ in found]
    assert [piece.start for piece, _ in other] != [piece.start for piece, _ in found]


def test_augmentation_gives_up_where_nothing_matches() -> None:
    found, report = augmentation([_part(_straight(0.2, 0.1))], count=10, seed=1)
    assert not found and report.tried == 0 and report.share == 0.0


def test_a_restaged_world_goes_on_nearly_as_the_real_one() -> None:
    trajectory = _straight(0.5, 0.5, ticks=12)
    states = states_of(trajectory.map, trajectory.actions)
    world = restage(trajectory.map, states[4])
    for action in trajectory.actions[4:]:
        world.step(action)
    assert np.allclose(world.state().robot_poses, states[12].robot_poses, atol=0.03)


def test_a_hand_that_cannot_reach_is_told() -> None:
    trajectory = _straight(0.0, 0.0, ticks=2)
    state = states_of(trajectory.map, trajectory.actions)[1]
    state.held[0] = 3
    with pytest.raises(WorldError, match="cannot be restored"):
        restage(trajectory.map, state)
