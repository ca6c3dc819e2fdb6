"""The layout of a learned policy's observation."""

from dataclasses import replace

import numpy as np
import pytest

from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import load_map
from movingout.world import WorldError
from movingout.world.observation import LAYOUTS, encode_state, encoder
from tests.agents.learning import states_of, walked


def test_one_state_and_a_whole_episode_are_encoded_to_the_same_numbers() -> None:
    trajectory = walked(ticks=30)
    states = states_of(trajectory.map, trajectory.actions)
    for layout in LAYOUTS:
        own = encoder(trajectory.map, layout)
        for seat in (0, 1):
            whole = trajectory.features(seat, layout)
            single = own.encode(states[17], seat).astype(np.float32)
            assert np.array_equal(whole[17], single)
            assert whole.shape == (30, LAYOUTS[layout].size)


def test_official_layouts_are_those_of_the_world() -> None:
    trajectory = walked(ticks=3)
    state = states_of(trajectory.map, trajectory.actions)[3]
    for layout in ("official-v1", "map-v1"):
        encoded = encoder(trajectory.map, layout).encode(state, 1)
        assert np.array_equal(encoded, encode_state(trajectory.map, state, 1, layout))


def test_the_aware_layout_says_who_holds_what_and_which_way_the_goal_is() -> None:
    the_map = load_map("DistancePriority")
    trajectory = walked("DistancePriority", ticks=1)
    held = trajectory.held[:1].copy()
    held[0, 1] = 2
    seen = encoder(the_map, "aware-v1")
    rows = {
        seat: seen.encode_arrays(
            trajectory.robot_poses[:1], trajectory.robot_velocities[:1], held, trajectory.item_poses[:1], seat
        )[0]
        for seat in (0, 1)
    }
    item = 173 + 15 * 2
    assert rows[0][item : item + 4].tolist() == [1, 0, 0, 1]  # exists, not delivered, not mine, the partner's
    assert rows[1][item : item + 4].tolist() == [1, 0, 1, 0]
    own = trajectory.robot_poses[0, 0, :2]
    assert np.allclose(rows[0][item + 4 : item + 6], trajectory.item_poses[0, 2, :2] - own)
    assert np.allclose(rows[0][169:171], trajectory.robot_poses[0, 1, :2] - own)
    assert rows[0][173 + 15 * len(the_map.items) :].tolist() == [0.0] * 15 * (7 - len(the_map.items))


def test_a_map_with_too_many_goals_is_refused_in_the_layouts_own_name() -> None:
    """It was refused in that of map-v1, which nobody had chosen."""
    the_map = load_map("HandOff")
    crowded = replace(the_map, goals=the_map.goals * 5)
    with pytest.raises(WorldError, match="the layout aware-v1 has 4 slots for goals; HandOff has "):
        encoder(crowded, "aware-v1")


def test_an_unknown_layout_is_answered_with_those_that_exist() -> None:
    with pytest.raises(WorldError, match="known: official-v1, map-v1, aware-v1"):
        encoder(load_map("HandOff"), "aware-v9")


def test_an_agent_in_a_seat_can_ask_for_every_layout() -> None:
    the_map = load_map("HandOff")
    state = start_state(the_map)
    for layout in LAYOUTS:
        seen = observe(the_map, state, 1).encode(layout)
        assert np.array_equal(seen, encode_state(the_map, state, 1, layout))
        assert seen.shape == LAYOUTS[layout].bounds.shape
