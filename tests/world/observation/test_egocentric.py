from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.maps import Rect, load_map, map_names
from movingout.maps.spec import SHAPES, SIZES
from movingout.world.errors import WorldError
from movingout.world.observation import LAYOUTS, encode_state, encoder
from tests.support import reference
from tests.world.states import OFFICIAL_FILES, changed, official_arrays, official_states, start_of


def test_the_official_recordings_are_there() -> None:
    assert reference("golden").is_dir()


@pytest.mark.parametrize("path", OFFICIAL_FILES, ids=lambda path: path.stem)
def test_official_layout_equals_the_official_encoding_to_the_bit(path: Path) -> None:
    map_spec, states = official_states(path)
    official = official_arrays(path)
    for step, views in zip(official["encoded_steps"], official["encoded"], strict=True):
        np.testing.assert_array_equal(encoder(map_spec).encode_both(states[int(step)]), views)


def test_each_number_stands_where_the_table_says() -> None:
    map_spec = load_map("CornerDecision")
    state = changed(start_of(map_spec), held=(-1, 3), robots={1: (0.5, -0.25, 0.0)})
    state.robot_velocities[1] = 1.0, 2.0, 3.0
    seen = encode_state(map_spec, state, 1)
    assert seen[:8].tolist() == [0.5, -0.25, 1.0, 0.0, 1.0, 1.0, 2.0, 3.0]
    assert seen[8:10].tolist() == [-0.15, 0.15]
    assert seen[12] == -1.0
    middle_square = seen[16 + 15 : 16 + 30]
    assert middle_square[:2].tolist() == [0.75, 1.0]
    assert middle_square[4:12].tolist() == [float(shape == "square") for shape in SHAPES]
    assert middle_square[12:].tolist() == [float(size == "middle") for size in SIZES]
    assert not seen[16 + 6 * 15 :].any()


def test_map_layout_adds_walls_and_goals_as_top_left_and_bottom_right() -> None:
    map_spec = load_map("CornerDecision")
    state = start_of(map_spec)
    seen = encode_state(map_spec, state, 0, "map-v1")
    np.testing.assert_array_equal(seen[:121], encode_state(map_spec, state, 0))
    assert seen[121:129].tolist() == [-0.2, 1.2, 0.2, 0.8, -0.2, -0.8, 0.2, -1.2]
    assert not seen[129:153].any()
    assert seen[153:161].tolist() == [-1.2, 1.2, -0.6, 0.8, 0.6, -0.8, 1.2, -1.2]
    assert not seen[161:].any()


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("name", [*map_names(), "Simple"])
def test_every_map_fits_every_layout(name: str, layout: str) -> None:
    map_spec = load_map(name)
    assert encode_state(map_spec, start_of(map_spec), 0, layout).shape == (LAYOUTS[layout].size,)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_whole_episode_encodes_as_its_states_do_one_by_one(layout: str) -> None:
    map_spec = load_map("PassOrSplit")
    states = [changed(start_of(map_spec), held=(k % 3 - 1, -1), robots={0: (0.1 * k, 0.0, 0.3 * k)}) for k in range(7)]
    for seat in (0, 1):
        together = encoder(map_spec, layout).encode_arrays(
            np.array([state.robot_poses for state in states]),
            np.array([state.robot_velocities for state in states]),
            np.array([state.held for state in states]),
            np.array([state.item_poses for state in states]),
            seat,
        )
        np.testing.assert_array_equal(together, [encode_state(map_spec, state, seat, layout) for state in states])


def test_vectors_are_the_callers_own() -> None:
    map_spec = load_map("HandOff")
    first = encode_state(map_spec, start_of(map_spec), 0)
    first[:] = 7.0
    assert not (encode_state(map_spec, start_of(map_spec), 0) == 7.0).any()


def test_an_unknown_layout_is_refused_with_the_known_ones() -> None:
    with pytest.raises(WorldError, match="unknown layout 'map'; known: official-v1, map-v1"):
        encoder(load_map("HandOff"), "map")


def test_a_map_with_too_many_walls_is_refused_where_walls_are_encoded() -> None:
    crowded = replace(load_map("HandOff"), walls=(Rect(0.0, 0.0, 0.1, 0.1),) * 9)
    assert encode_state(crowded, start_of(crowded), 0).shape == (121,)
    with pytest.raises(WorldError, match="map-v1 has 8 slots for walls; HandOff has 9"):
        encoder(crowded, "map-v1")
