from dataclasses import replace

import pytest

from movingout.maps import ItemSpec, MapSpec, Pose, Rect, load_map
from movingout.world import WorldState
from movingout.world.reward import PaperReward
from tests.world.states import changed, start_of

FAR, NEAR = (-1.025, -1.025, 0.0), (-1.025, -0.975, 0.0)  # one cell apart on the way up
HOME = (0.0, 1.08, 0.0)
SMALL, OTHER_SMALL, MIDDLE, LARGE = range(4)


@pytest.fixture
def room() -> MapSpec:
    """An open room, the goal along the upper side; two small items, a middle and a large one in a row at y = -0.025."""
    sizes = ("small", "small", "middle", "large")
    items = [ItemSpec(i, "circle", sizes[i], 0.1, 0.5, Pose(-0.9 + 0.6 * i, -0.025, 0.0)) for i in range(4)]  # type: ignore[arg-type]
    robots = (Pose(*FAR), Pose(1.0, -1.025, 0.0))
    return replace(load_map("Simple"), goals=(Rect(-1.2, 1.0, 1.2, 1.2),), items=tuple(items), walls=(), robots=robots)


def paid(room: MapSpec, before: WorldState, after: WorldState, dense: bool = True) -> float:
    """What blue gets for a tick."""
    return float(PaperReward(room, dense)(before, after)[0])


def test_standing_still_costs_a_hundredth(room: MapSpec) -> None:
    start = start_of(room)
    assert PaperReward(room)(start, start).tolist() == [-0.01, -0.01]


def test_an_empty_hand_is_paid_for_coming_nearer_to_the_nearest_free_item(room: MapSpec) -> None:
    start = start_of(room)
    nearer = changed(start, robots={0: NEAR})
    assert paid(room, start, nearer) == pytest.approx(20 * 0.05 - 0.01)
    assert paid(room, nearer, start) == pytest.approx(-20 * 0.05 - 0.01)
    assert paid(room, start, nearer, dense=False) == -0.01


def test_an_empty_hand_is_paid_for_coming_to_help_instead(room: MapSpec) -> None:
    start = changed(start_of(room), held=(-1, LARGE))
    nearer_to_a_small_one = changed(start, robots={0: (-1.075, -1.025, 0.0)})
    nearer_to_the_large_one = changed(start, robots={0: (-0.975, -1.025, 0.0)})
    assert paid(room, start, nearer_to_the_large_one) == pytest.approx(20 * 0.05 - 0.01)
    assert paid(room, start, nearer_to_a_small_one) == pytest.approx(-20 * 0.05 - 0.01)


def test_a_delivered_item_needs_no_help_and_draws_nobody(room: MapSpec) -> None:
    start = changed(start_of(room), held=(-1, LARGE), items={LARGE: HOME, SMALL: HOME})
    nearer = changed(start, robots={0: NEAR})
    assert paid(room, start, nearer) == pytest.approx(20 * 0.05 - 0.01)  # to the other small one


def test_a_full_hand_is_paid_for_bringing_its_item_nearer_to_a_goal(room: MapSpec) -> None:
    start = changed(start_of(room), held=(SMALL, -1))
    nearer = changed(start, items={SMALL: (-0.9, 0.025, 0.0)})
    assert paid(room, start, nearer) == pytest.approx(20 * 0.05 - 0.01)


def test_or_for_its_own_way_to_a_goal_as_the_papers_text_has_it(room: MapSpec) -> None:
    reward, start = PaperReward(room, carrier=True), changed(start_of(room), held=(SMALL, -1))
    pulled = changed(start, items={SMALL: (-0.9, 0.025, 0.0)})
    assert float(reward(start, pulled)[0]) == pytest.approx(-0.01), "the item comes nearer, its carrier does not"
    walked = changed(start, robots={0: NEAR})
    assert float(reward(start, walked)[0]) == pytest.approx(20 * 0.05 - 0.01)
    assert paid(room, start, walked) == pytest.approx(-0.01)
    empty = start_of(room)
    assert float(reward(empty, changed(empty, robots={0: NEAR}))[0]) == pytest.approx(20 * 0.05 - 0.01)


@pytest.mark.parametrize(
    ("partner", "items", "event"),
    [
        (-1, {}, 0.5),
        (OTHER_SMALL, {}, 0.5),  # a partner with a small item needs nobody
        (LARGE, {}, -0.5),
        (-1, {SMALL: HOME}, -0.5),
        (LARGE, {SMALL: HOME}, -0.5),  # in total, not twice
    ],
)
@pytest.mark.parametrize("dense", [True, False])
def test_picking_up(
    room: MapSpec, partner: int, items: dict[int, tuple[float, float, float]], event: float, dense: bool
) -> None:
    before = changed(start_of(room), held=(-1, partner), items=items)
    assert paid(room, before, changed(before, held=(SMALL, partner)), dense) == pytest.approx(event - 0.01)


def test_joining_the_partner_at_its_item_is_a_good_hold(room: MapSpec) -> None:
    before = changed(start_of(room), held=(-1, LARGE))
    assert paid(room, before, changed(before, held=(LARGE, LARGE))) == pytest.approx(0.5 - 0.01)


@pytest.mark.parametrize(
    ("partner", "items", "event"),
    [
        (-1, {}, -0.5),
        (-1, {SMALL: HOME}, 0.5),
        (LARGE, {}, 0.0),  # -0.5 for where it lies, +0.5 for letting go to help
        (LARGE, {SMALL: HOME}, 1.0),
        (LARGE, {LARGE: HOME}, -0.5),  # the partner's item is home: no help is needed
    ],
)
def test_letting_go(room: MapSpec, partner: int, items: dict[int, tuple[float, float, float]], event: float) -> None:
    before = changed(start_of(room), held=(SMALL, partner), items=items)
    assert paid(room, before, changed(before, held=(-1, partner))) == pytest.approx(event - 0.01)


def test_leaving_the_partner_alone_with_the_item_is_no_help(room: MapSpec) -> None:
    before = changed(start_of(room), held=(LARGE, LARGE))
    assert paid(room, before, changed(before, held=(-1, LARGE))) == pytest.approx(-0.5 - 0.01)


def test_a_large_rectangle_is_approached_at_its_short_sides(room: MapSpec) -> None:
    plank = ItemSpec(0, "rectangle", "large", 0.4, 0.5, Pose(0.0, -0.025, 0.0))  # its short sides are at x = +-0.354
    alone = replace(room, items=(plank,))
    start = changed(start_of(alone), robots={0: (0.0, -0.375, 0.0)})  # below the middle: 7 cells, as far as either side
    nearer_to_the_middle = changed(start, robots={0: (0.0, -0.225, 0.0)})
    nearer_to_a_side = changed(start, robots={0: (0.15, -0.375, 0.0)})
    assert paid(alone, start, nearer_to_the_middle) == pytest.approx(-0.01)
    assert paid(alone, start, nearer_to_a_side, dense=False) == pytest.approx(-0.01)
