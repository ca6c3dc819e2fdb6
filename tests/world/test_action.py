import math

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.world import World
from movingout.world.action import POLICY_SIZE, checked, clipped, in_arena, to_policy, to_world, turned
from movingout.world.errors import ActionError


def test_a_policy_action_becomes_distance_heading_and_a_press() -> None:
    assert to_world([0.5, 0.0, 2.0, 0.9]).tolist() == [0.5, math.pi / 2, 1.0]


def test_distances_beyond_one_are_clipped_at_the_rim() -> None:
    assert to_world([[3.0, 1.0, 0.0, 0.0], [-7.0, 1.0, 0.0, 0.0]])[:, 0].tolist() == [1.0, -1.0]
    assert clipped([-1.5, 9.0, 1.0]).tolist() == [-1.0, 9.0, 1.0]
    assert to_policy([1.5, 0.0, 0.0]).tolist() == [1.0, 1.0, 0.0, 0.0]


def test_converting_there_and_back_changes_nothing() -> None:
    generator = np.random.default_rng(3)
    world = np.stack(
        [generator.uniform(-1, 1, (5, 2)), generator.uniform(-3, 3, (5, 2)), generator.integers(0, 2, (5, 2))], axis=-1
    )
    np.testing.assert_allclose(to_world(to_policy(world)), world, rtol=0, atol=1e-15)


def test_a_pair_of_zeros_is_heading_zero() -> None:
    assert to_world([0.0, 0.0, 0.0, 0.0]).tolist() == [0.0, 0.0, 0.0]


def test_headings_are_turned_with_their_robots_and_back() -> None:
    chunks = np.random.default_rng(1).normal(size=(2, 3, POLICY_SIZE))
    angles = np.array([math.pi / 2, -1.0])
    ahead = turned(chunks, angles)
    np.testing.assert_allclose(ahead[0, :, 1:3], np.stack((-chunks[0, :, 2], chunks[0, :, 1]), axis=-1), atol=1e-15)
    np.testing.assert_allclose(turned(ahead, -angles), chunks, rtol=0, atol=1e-15)
    assert turned(chunks.astype(np.float32), angles).dtype == np.float32
    np.testing.assert_array_equal(turned(chunks[1], -1.0), ahead[1])


@pytest.mark.parametrize("own_frame", [False, True])
def test_a_pair_of_zeros_keeps_the_robots_own_heading_in_the_arena(own_frame: bool) -> None:
    rows = np.array([[0.5, 0.0, 0.0, 1.0], [0.5, 0.0, 2.0, 0.0]])
    found = to_world(in_arena(rows, 0.25, own_frame))
    np.testing.assert_allclose(found[:, 1], [0.25, math.pi / 2 + 0.25 * own_frame], atol=1e-15)
    np.testing.assert_array_equal(in_arena(rows[0], 0.25, own_frame), in_arena(rows, 0.25, own_frame)[0])
    assert rows[0, 1] == 0.0


def test_the_input_is_never_changed() -> None:
    given = np.array([2.0, 1.0, 0.7])
    clipped(given)
    assert given.tolist() == [2.0, 1.0, 0.7]


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_not_finite_is_refused_with_its_place(number: float) -> None:
    with pytest.raises(ActionError, match=r"index \(1, 2\)"):
        to_world(np.array([[0, 1, 0, 0], [0, 1, number, 0]]))


@pytest.mark.parametrize("wrong", [[1.0, 2.0], 3.0, [[1, 2, 3, 4, 5]], "go", [[1, 2, 3], [1]]])
def test_a_wrong_shape_is_refused_with_a_sentence(wrong: object) -> None:
    with pytest.raises(ActionError, match="an action is 3 numbers"):
        checked(wrong, 3)  # type: ignore[arg-type]


def test_a_tensor_that_requires_grad_is_refused_with_what_to_do() -> None:
    torch = pytest.importorskip("torch")
    action = torch.zeros(4, requires_grad=True)
    with pytest.raises(ActionError, match=r"an action is 4 numbers, not tensor\(.*detach\(\)"):
        to_world(action)
    with pytest.raises(ActionError, match=r"actions are \(2, 3\) numbers: .*detach\(\)"):
        World(load_map("HandOff")).step(torch.zeros((2, 3), requires_grad=True))


def test_equal_actions_are_equal_headings_on_every_processor() -> None:
    """NumPy's own arctan2 differs in last bits where there is AVX-512."""
    policy = np.random.default_rng(0).normal(size=(2000, POLICY_SIZE))
    expected = [math.atan2(sin, cos) for _, cos, sin, _ in policy.tolist()]
    np.testing.assert_array_equal(to_world(policy)[:, 1], expected)
