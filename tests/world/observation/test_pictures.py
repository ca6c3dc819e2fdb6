"""The layout that is a picture."""

from dataclasses import replace

import numpy as np

from movingout.agents.observation.features import FeatureSet
from movingout.maps import load_map
from movingout.world import World
from movingout.world.observation import LAYOUTS, PICTURE_LAYOUT, PICTURE_SHAPE, encode_state
from tests.agents.learning import walked


def test_a_picture_has_the_size_that_its_layout_says_and_shows_bytes() -> None:
    the_map = load_map("DistancePriority")
    seen = encode_state(the_map, World(the_map).state(), 0, PICTURE_LAYOUT)
    assert LAYOUTS[PICTURE_LAYOUT].picture == PICTURE_SHAPE == (128, 128, 3)
    assert seen.shape == (128 * 128 * 3,) and seen.min() >= 0.0 and seen.max() <= 255.0 and len(set(seen)) > 10


def test_the_other_seats_picture_is_the_same_scene_with_the_colours_of_the_robots_exchanged() -> None:
    the_map = load_map("DistancePriority")
    state = World(the_map).state()
    blue, red = (encode_state(the_map, state, seat, PICTURE_LAYOUT).reshape(PICTURE_SHAPE) for seat in (0, 1))
    places = state.robot_poses[:, :2]
    exchanged = replace(state, robot_poses=state.robot_poses[::-1].copy())
    assert np.array_equal(encode_state(the_map, exchanged, 1, PICTURE_LAYOUT).reshape(PICTURE_SHAPE), blue)
    for x, y in places:
        row, column = round((1.2 - y) / 2.4 * 128), round((x + 1.2) / 2.4 * 128)
        around = (slice(max(row - 12, 0), row + 12), slice(max(column - 12, 0), column + 12))
        assert not np.array_equal(blue[around], red[around])
    own = blue[..., 2] - blue[..., 0] > 80  # strongly blue: the own robot
    assert own.any() and not np.array_equal(own, red[..., 2] - red[..., 0] > 80)


def test_an_episode_of_pictures_is_kept_as_bytes() -> None:
    walk = walked(ticks=5)
    film = walk.features(1, FeatureSet(PICTURE_LAYOUT))
    assert film.dtype == np.uint8 and film.shape == (5, 49152)
    assert np.array_equal(film[0], encode_state(walk.map, World(walk.map).state(), 1, PICTURE_LAYOUT))
