from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.maps import ItemSpec, MapSpec, Pose, Rect, load_map
from movingout.world.metrics import (
    EpisodeMetrics,
    Metrics,
    normalized_final_distance,
    official_normalized_final_distance,
    official_tick_consistency,
    task_completion_rate,
    tick_consistency,
)
from tests.world.states import OFFICIAL_FILES, changed, official_arrays, official_states, start_of

STILL = np.zeros((2, 3))
SIDE_BY_SIDE = np.array([(-0.3, 0.0, 0.0), (0.3, 0.0, 0.0)])  # the line between them is the x axis
ALONG_X, AGAINST_X, ALONG_Y = -np.pi / 2, np.pi / 2, 0.0  # headings: 0 looks along +y


@pytest.fixture
def room() -> MapSpec:
    """An open room, the goal along its upper side; a small, a middle and a large item at growing distance."""
    places: list[tuple[str, float]] = [("small", 0.475), ("middle", -0.025), ("large", -0.525)]
    items = [
        ItemSpec(i, "circle", size, 0.1, 0.5, Pose(-0.875 + 0.6 * i, y, 0.0))  # type: ignore[arg-type]
        for i, (size, y) in enumerate(places)
    ]
    return replace(load_map("Simple"), goals=(Rect(-1.2, 1.0, 1.2, 1.2),), items=tuple(items), walls=())


def pulls(*moves: tuple[float, float]) -> np.ndarray:
    """World actions (2, 3) of (distance, heading) pairs."""
    return np.array([(distance, heading, 0.0) for distance, heading in moves])


def test_completion_weighs_middle_and_large_items_twice(room: MapSpec) -> None:
    assert task_completion_rate(room, np.array([True, False, False])) == 1 / 5
    assert task_completion_rate(room, np.array([False, True, True])) == 4 / 5
    assert task_completion_rate(room, np.array([True, True, True])) == 1.0


def test_final_distance_is_what_is_left_of_the_way(room: MapSpec) -> None:
    start = start_of(room)
    distances = [11 * 0.05, 21 * 0.05, 31 * 0.05]  # moves to the first goal row
    assert normalized_final_distance(room, start.item_poses) == 0.0
    halfway = changed(start, items={2: (0.3, -0.525 + 0.75, 0.0)})  # 15 cells nearer
    expected = 1 - (sum(distances) - 15 * 0.05) / sum(distances)
    assert normalized_final_distance(room, halfway.item_poses) == pytest.approx(expected)
    home = changed(start, items={i: (0.0, 1.1, 0.0) for i in range(3)})
    assert normalized_final_distance(room, home.item_poses) == 1.0
    farther = changed(start, items={0: (0.0, -1.0, 0.0)})
    assert normalized_final_distance(room, farther.item_poses) < 0.0


def test_final_distance_takes_many_predictions_at_once(room: MapSpec) -> None:
    poses = np.stack([start_of(room).item_poses + np.array([0.0, 0.05 * k, 0.0]) for k in range(4)])
    many = normalized_final_distance(room, poses.reshape(2, 2, 3, 3))
    assert many.shape == (2, 2)
    assert many[1, 0] == normalized_final_distance(room, poses[2])


def test_everything_at_home_from_the_start_is_one(room: MapSpec) -> None:
    home = replace(room, items=tuple(replace(item, pose=Pose(0.0, 1.1, 0.0)) for item in room.items))
    assert normalized_final_distance(home, start_of(home).item_poses) == 1.0
    assert normalized_final_distance(home, start_of(room).item_poses) == 0.0


def test_items_that_stick_out_of_their_goal_from_the_start_have_covered_nothing(room: MapSpec) -> None:
    halfway = replace(room, items=tuple(replace(item, pose=Pose(0.0, 1.02, 0.0)) for item in room.items))
    first = start_of(halfway).item_poses
    one_home = first + np.array([[0.0, 0.08, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    poses = np.stack([first, one_home, first + np.array([0.0, 0.08, 0.0]), start_of(room).item_poses])
    assert normalized_final_distance(halfway, poses).tolist() == [0.0, 0.0, 1.0, 0.0]


def test_an_item_without_a_way_counts_as_the_farthest_place_that_has_one(room: MapSpec) -> None:
    closed = replace(room, walls=(Rect(-1.2, -0.3, 1.2, -0.2),))
    poses = start_of(closed).item_poses
    assert normalized_final_distance(closed, poses) == 0.0
    assert np.isfinite(normalized_final_distance(closed, changed(start_of(closed), items={0: (0, 1.1, 0)}).item_poses))


@pytest.mark.parametrize(
    ("held", "agents_waiting"),
    [
        ((-1, -1), 0),
        ((0, -1), 0),  # a small item needs nobody
        ((1, -1), 1),  # a middle one dragged alone is slow
        ((-1, 2), 1),
        ((0, 2), 1),  # the partner is busy
        ((1, 2), 2),
        ((2, 2), 0),  # help is here
        ((1, 1), 0),
    ],
)
def test_an_agent_waits_while_it_alone_holds_a_middle_or_large_item(
    room: MapSpec, held: tuple[int, int], agents_waiting: int
) -> None:
    state = changed(start_of(room), held=held)
    metrics = EpisodeMetrics(room)
    for _ in range(5):
        metrics.update(state, STILL, state)
    assert metrics.result().wt_s == pytest.approx(agents_waiting * 0.5)


def test_nobody_waits_with_an_item_that_is_delivered(room: MapSpec) -> None:
    state = changed(start_of(room), held=(2, -1), items={2: (0.0, 1.08, 0.0)})
    metrics = EpisodeMetrics(room)
    metrics.update(state, STILL, state)
    assert metrics.result().wt_s == 0.0


@pytest.mark.parametrize(
    ("blue", "red", "expected"),
    [
        ((1.0, ALONG_X), (1.0, ALONG_X), 1.0),
        ((1.0, ALONG_X), (1.0, AGAINST_X), 0.0),
        ((1.0, ALONG_X), (0.5, AGAINST_X), 0.5 / 1.5),
        ((1.0, ALONG_X), (0.0, ALONG_Y), 1.0),
        ((1.0, ALONG_Y), (1.0, ALONG_Y), 0.0),
        ((1.0, ALONG_X), (1.0, ALONG_Y), 0.5),
        ((1.0, ALONG_X), (-1.0, AGAINST_X), 1.0),  # driving backward pulls the other way
        ((5.0, ALONG_X), (1.0, AGAINST_X), 0.0),  # beyond 1 the motor gives no more
    ],
)
def test_consistency_is_the_share_of_the_pushes_that_adds_up_along_the_line(
    blue: tuple[float, float], red: tuple[float, float], expected: float
) -> None:
    assert tick_consistency(SIDE_BY_SIDE, pulls(blue, red)) == pytest.approx(expected, abs=1e-12)


def test_consistency_is_undefined_when_nobody_pushes_or_both_stand_on_one_point() -> None:
    assert tick_consistency(SIDE_BY_SIDE, STILL) is None
    assert tick_consistency(np.zeros((2, 3)), pulls((1.0, 0.0), (1.0, 0.0))) is None


def test_consistency_counts_only_ticks_of_joint_holding_in_which_somebody_pushes(room: MapSpec) -> None:
    start = start_of(room)
    together = changed(start, held=(2, 2), robots={0: (-0.3, 0, 0), 1: (0.3, 0, 0)})
    good, bad = pulls((1.0, ALONG_X), (1.0, ALONG_X)), pulls((1.0, ALONG_X), (1.0, AGAINST_X))
    metrics = EpisodeMetrics(room)
    assert metrics.result().ac is None
    for state, actions in [(start, good), (together, good), (together, STILL), (together, bad), (together, good)]:
        metrics.update(state, actions, state)
    assert metrics.result().ac == pytest.approx(2 / 3)


def test_a_whole_episode_gives_the_same_as_its_ticks(room: MapSpec) -> None:
    states = [start_of(room), changed(start_of(room), held=(1, -1)), changed(start_of(room), held=(1, 1))]
    states.append(changed(states[-1], items={1: (0.0, 1.08, 0.0)}))
    actions = np.stack([pulls((1.0, 0.3), (0.4, 0.1))] * 3)
    live, whole = EpisodeMetrics(room), EpisodeMetrics(room)
    for index in range(3):
        live.update(states[index], actions[index], states[index + 1])
    whole.update_episode(states, actions)
    assert live.result() == whole.result()
    assert live.result().tcr == 2 / 5
    assert live.result().wt_s == pytest.approx(0.1)


def test_before_the_first_tick_nothing_is_done() -> None:
    assert EpisodeMetrics(load_map("FourCorners")).result() == Metrics.of({"tcr": 0.0, "nfd": 0.0, "wt_s": 0.0})


def test_official_score_counts_items_and_official_waiting_is_a_fraction_of_ticks(room: MapSpec) -> None:
    start = start_of(room)
    metrics = EpisodeMetrics(room)
    for held in [(-1, -1), (2, -1), (1, 2), (0, 2)]:  # the official code does not count waiting for a busy partner
        state = changed(start, held=held, items={0: (0.0, 1.08, 0.0)})
        metrics.update(state, STILL, state)
    assert metrics.official().score == 1 / 3
    assert metrics.official().waiting == 2 / 4
    assert metrics.result().tcr == 1 / 5


def test_official_consistency_sees_directions_a_quarter_turn_off_and_only_what_cancels() -> None:
    assert official_tick_consistency(SIDE_BY_SIDE, STILL) == 1.0
    assert official_tick_consistency(SIDE_BY_SIDE, pulls((1.0, 0.0), (1.0, np.pi))) == pytest.approx(0.0)
    assert official_tick_consistency(SIDE_BY_SIDE, pulls((1.0, ALONG_X), (1.0, AGAINST_X))) == pytest.approx(1.0)


def test_official_consistency_of_an_episode_is_the_mean_over_the_ticks_of_joint_holding(room: MapSpec) -> None:
    """The official code adds 1e-5 to their number, and has 0 where there are none."""
    metrics, alone = EpisodeMetrics(room), changed(start_of(room), held=(2, -1))
    metrics.update(alone, pulls((1.0, 0.0), (1.0, np.pi)), alone)
    assert metrics.official_ac is None and metrics.official().consistency == 0.0
    together = replace(changed(alone, held=(2, 2)), robot_poses=SIDE_BY_SIDE)
    for actions in (STILL, pulls((1.0, 0.0), (1.0, np.pi)), pulls((1.0, ALONG_X), (1.0, AGAINST_X))):
        metrics.update(together, actions, together)
    assert metrics.official_ac == metrics.official().consistency == pytest.approx(2 / 3, abs=1e-5)
    assert metrics.result().ac == pytest.approx(0.0), "by the formula both pushes cancel out"


def test_official_final_distance_is_a_straight_line_without_walls(room: MapSpec) -> None:
    poses = changed(start_of(room), items={0: (0.0, 1.1, 0.0)}).item_poses
    initial = 0.525 + 1.025 + 1.525
    assert official_normalized_final_distance(room, poses) == pytest.approx(0.525 / initial)


@pytest.mark.parametrize("path", OFFICIAL_FILES[::7], ids=lambda path: path.stem)
def test_official_score_equals_the_recorded_one(path: Path) -> None:
    map_spec, states = official_states(path)
    official = official_arrays(path)
    metrics = EpisodeMetrics(map_spec)
    metrics.update_episode(states, official["actions"].astype(np.float64))
    assert metrics.official().score == official["score"][-1]
    everything = official["score"][-1] == 1.0
    assert (metrics.result().tcr == 1.0) == everything
    assert metrics.result().nfd <= 1.0
