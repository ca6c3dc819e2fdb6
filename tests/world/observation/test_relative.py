"""The layout without absolute places: alike in every turn of the arena and for both seats, mirrored in a mirror."""

from dataclasses import replace

import numpy as np
import pytest

from movingout.maps import MapSpec, Rect, load_map
from movingout.maps.symmetry import ALL_SYMMETRIES, Symmetry, transformed
from movingout.world.errors import WorldError
from movingout.world.observation import LAYOUTS, encode_state
from movingout.world.observation.memory import Moments, memory_block, memory_of_the_present, memory_signs
from movingout.world.observation.relative import RELATIVE_ITEMS, RELATIVE_LAYOUT, relative_mirror
from movingout.world.observation.ways import FAR, way_finder
from movingout.world.state import Floats, WorldState

NAMES = ("HandOff", "PassOrSplit", "FourCorners", "generated:awareness:21")


def random_state(spec: MapSpec, seed: int) -> WorldState:
    random, count = np.random.default_rng(seed), len(spec.items)

    def poses(rows: int) -> Floats:
        return np.column_stack((random.uniform(-1.07, 1.07, (rows, 2)), random.uniform(-4.0, 4.0, rows)))

    return WorldState(0, poses(2), random.normal(size=(2, 3)), random.integers(-1, count, 2), poses(count))


def moved(state: WorldState, symmetry: Symmetry) -> WorldState:
    def poses(rows: Floats) -> Floats:
        return np.array([(*symmetry.point(float(x), float(y)), symmetry.angle(float(a))) for x, y, a in rows])

    spin = -1.0 if symmetry.mirrored else 1.0
    velocities = [(*symmetry.point(float(x), float(y)), spin * w) for x, y, w in state.robot_velocities]
    return replace(
        state,
        robot_poses=poses(state.robot_poses),
        robot_velocities=np.array(velocities),
        item_poses=poses(state.item_poses),
    )


def seen(spec: MapSpec, state: WorldState, seat: int = 0) -> Floats:
    return encode_state(spec, state, seat, RELATIVE_LAYOUT)


@pytest.mark.parametrize("name", NAMES)
def test_a_moved_state_is_seen_alike_and_a_mirrored_one_as_its_mirror_image(name: str) -> None:
    spec, (order, signs) = load_map(name), relative_mirror()
    for seed in range(5):
        state = random_state(spec, seed)
        plain = seen(spec, state)
        for symmetry in ALL_SYMMETRIES:
            expected = plain[order] * signs if symmetry.mirrored else plain
            found = seen(transformed(spec, symmetry), moved(state, symmetry))
            np.testing.assert_allclose(found, expected, atol=1e-9, err_msg=str(symmetry))


def test_mirroring_twice_changes_nothing() -> None:
    order, signs = relative_mirror()
    numbers = np.arange(1.0, len(order) + 1)
    once = numbers[order] * signs
    assert not np.array_equal(once, numbers)
    assert np.array_equal(once[order] * signs, numbers)
    assert np.array_equal(memory_signs() ** 2, np.ones(36))


@pytest.mark.parametrize("layout", LAYOUTS)
def test_both_seats_see_alike(layout: str) -> None:
    spec = load_map("AdaptiveAssist")
    state = random_state(spec, 3)
    exchanged = replace(
        state,
        robot_poses=state.robot_poses[::-1],
        robot_velocities=state.robot_velocities[::-1],
        held=state.held[::-1],
    )
    np.testing.assert_allclose(encode_state(spec, exchanged, 1, layout), encode_state(spec, state, 0, layout))


def test_what_is_ahead_and_to_the_left_has_positive_numbers() -> None:
    spec = load_map("DistancePriority")
    state = random_state(spec, 0)
    poses = np.array([[0.2, 0.1, np.pi / 2], [-0.3, -0.2, 0.0]])  # own robot looks along -x; its left is -y
    row = seen(spec, replace(state, robot_poses=poses, held=np.array([-1, 2])))
    np.testing.assert_allclose(row[8:10], [0.5, 0.3], atol=1e-12)
    np.testing.assert_allclose(row[10:12], [0.0, -1.0], atol=1e-12)  # the partner looks along +y, to our right
    assert (row[4], row[12]) == (-1.0, 1.0)
    assert row[18] == pytest.approx(np.hypot(0.5, 0.3) / 4) and row[19] == 1.0
    np.testing.assert_allclose(row[20:36:4], [1.4, 1.3, 1.0, 1.1], atol=1e-9)  # ahead, left, behind, right
    assert [row[item[3]] for item in RELATIVE_ITEMS] == [0, 0, 1, 0, 0, 0, 0]
    assert [row[item[0]] for item in RELATIVE_ITEMS] == [1, 1, 1, 1, 0, 0, 0]


def test_a_map_with_more_than_the_layout_holds_is_refused() -> None:
    spec = load_map("Simple")
    crowded = replace(spec, goals=tuple(Rect(0.1 * k, 0.0, 0.1 * k + 0.1, 0.1) for k in range(5)))
    with pytest.raises(WorldError, match="the layout relative-v1 has 4 slots for goals; Simple has 5"):
        seen(crowded, random_state(spec, 0))
    walls = tuple(Rect(-1.0 + 0.1 * k, 0.0, -0.95 + 0.1 * k, 0.1) for k in range(20))
    assert len(seen(replace(spec, walls=walls), random_state(spec, 0))) == LAYOUTS[RELATIVE_LAYOUT].size


def test_a_map_without_items_or_walls_is_seen() -> None:
    bare = replace(load_map("Simple"), items=(), walls=())
    state = replace(random_state(load_map("Simple"), 0), held=np.array([-1, -1]), item_poses=np.zeros((0, 3)))
    assert np.isfinite(seen(bare, state)).all()


def test_ways_lead_around_walls_and_say_where_there_is_none() -> None:
    finder = way_finder(load_map("SingleRotation"))  # a wall from the left side to x = 0.76 at y = -0.2
    start, target = np.array([[[-0.8, -0.7]]]), np.array([[[-0.8, 0.3]]])
    ways = finder.between(finder.seen(start), finder.seen(target))
    assert not ways.straight[0, 0] and 3.0 < ways.lengths[0, 0] < 4.0
    assert ways.directions[0, 0, 0] > 0.95  # to the right, along the wall
    closed = replace(load_map("Simple"), walls=(Rect(-1.2, 0.0, 1.2, 0.1),))
    finder = way_finder(closed)
    nowhere = finder.between(finder.seen(start), finder.seen(target))
    assert nowhere.lengths[0, 0] == FAR and not nowhere.straight[0, 0]


def test_memory_is_in_the_present_frame_and_mirrors() -> None:
    spec, mirror = load_map("DistancePriority"), Symmetry(mirrored=True)
    now, then = random_state(spec, 1), random_state(spec, 2)

    def block(*states: WorldState) -> Floats:
        here, there = (Moments(one.robot_poses[None], one.held[None], one.item_poses[None]) for one in states)
        return memory_block(here, there, 0).reshape(-1)

    plain = block(now, then)
    np.testing.assert_allclose(block(moved(now, mirror), moved(then, mirror)), plain * memory_signs(), atol=1e-12)
    for turn in ALL_SYMMETRIES[1:4]:
        np.testing.assert_allclose(block(moved(now, turn), moved(then, turn)), plain, atol=1e-9)
    sources, factors = memory_of_the_present()
    np.testing.assert_allclose(block(now, now), seen(spec, now)[sources] * factors, atol=1e-12)
