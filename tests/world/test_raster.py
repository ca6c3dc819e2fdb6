import numpy as np
import pytest

from movingout.maps import load_map, map_names
from movingout.world import World
from movingout.world.raster import picture, pixels
from tests.world.states import changed, start_of

BLUE, RED, WHITE = (0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00), (255, 255, 255)


def pixel(x: float, y: float) -> tuple[int, int]:
    """Row and column of a point of the arena in a picture of 256 pixels."""
    return round((1.2 - y) / 2.4 * 256), round((x + 1.2) / 2.4 * 256)


@pytest.mark.parametrize("name", [*map_names(), "Simple"])
def test_a_state_is_a_picture_of_256_by_256_bytes(name: str) -> None:
    map_spec = load_map(name)
    seen = pixels(map_spec, start_of(map_spec))
    assert seen.shape == (256, 256, 3)
    assert seen.dtype == np.uint8


def test_each_agent_is_blue_in_its_own_view() -> None:
    map_spec = load_map("LeftRight")
    state = changed(start_of(map_spec), robots={0: (-0.5, 0.75, 0.0), 1: (0.5, 0.75, 0.0)})
    left_of_the_letter, right_of_the_letter = pixel(-0.5 - 0.07, 0.75), pixel(0.5 - 0.07, 0.75)
    blues_view, reds_view = pixels(map_spec, state, seat=0), pixels(map_spec, state, seat=1)
    assert (tuple(blues_view[left_of_the_letter]), tuple(blues_view[right_of_the_letter])) == (BLUE, RED)
    assert (tuple(reds_view[left_of_the_letter]), tuple(reds_view[right_of_the_letter])) == (RED, BLUE)


def test_what_a_robot_does_shows() -> None:
    map_spec = load_map("LeftRight")
    start = start_of(map_spec)
    seen = {
        pixels(map_spec, state).tobytes()
        for state in (
            start,
            changed(start, robots={0: (-0.6, -1.0, 1.0)}),
            changed(start, held=(2, -1)),
            changed(start, held=(2, 2)),
            changed(start, items={0: (0.9, 0.8, 0.0)}),
        )
    }
    assert len(seen) == 5


def test_y_points_up_in_the_picture() -> None:
    map_spec = load_map("DistancePriority")  # its goal is at the top
    seen = pixels(map_spec, start_of(map_spec))
    assert tuple(seen[pixel(0.0, -1.1)]) == WHITE
    assert tuple(seen[pixel(0.0, 0.9)]) != WHITE


def test_painting_one_state_leaves_no_trace_in_the_next() -> None:
    map_spec = load_map("HandOff")
    start = start_of(map_spec)
    first = pixels(map_spec, start)
    pixels(map_spec, changed(start, robots={0: (0.1, 0.9, 2.0)}))
    np.testing.assert_array_equal(pixels(map_spec, start), first)


def test_a_world_shows_itself_as_it_is_now() -> None:
    world = World(load_map("HandOff"))
    start = world.render(side=128)
    world.step([[1.0, 0.5, 0], [0.0, 0.0, 0]])
    now = world.render(side=128)
    assert start.size == now.size == (128, 128)
    assert start.tobytes() != now.tobytes()
    assert now.tobytes() == picture(world.map, world.state(), side=128).tobytes()
