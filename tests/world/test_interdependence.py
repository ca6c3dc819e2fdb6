"""Who enabled which delivery, in scenes made by hand: one goal along the upper side, items below it."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from movingout.maps import ItemSpec, MapSpec, Pose, Rect, load_map
from movingout.world.metrics import EpisodeMetrics
from movingout.world.state import WorldState
from tests.world.states import changed, start_of

STILL = np.zeros((2, 3))
BLUE, RED, BOTH, NONE = (0, -1), (-1, 0), (0, 0), (-1, -1)
START, HALF_WAY, HOME = -0.5, 0.3, 1.1  # y of the item; the goal begins at 1.0
Scene = Sequence[tuple[tuple[int, int], float]]


@pytest.fixture
def room() -> MapSpec:
    items = tuple(ItemSpec(i, "circle", "small", 0.1, 0.5, Pose(0.6 * i, START, 0.0)) for i in range(2))
    return replace(load_map("Simple"), goals=(Rect(-1.2, 1.0, 1.2, 1.2),), items=items, walls=())


def states_of(room: MapSpec, scene: Scene) -> list[WorldState]:
    """What both hands hold and where item 0 lies, tick by tick."""
    states = [start_of(room)]
    for held, y in scene:
        states.append(changed(states[-1], held=held, items={0: (0.0, y, 0.0)}))
    return states


def interdependence(room: MapSpec, scene: Scene) -> float | None:
    metrics, states = EpisodeMetrics(room), states_of(room, scene)
    metrics.update_episode(states, np.stack([STILL] * len(scene)))
    return metrics.result().interdependence


@pytest.mark.parametrize(
    ("scene", "share"),
    [
        pytest.param([(BLUE, START), (BLUE, HOME), (NONE, HOME)], 0.0, id="carried alone"),
        pytest.param([(BOTH, START), (BOTH, HOME), (NONE, HOME)], 1.0, id="carried together"),
        pytest.param([(BOTH, START), (BOTH, HOME)], 1.0, id="still held in the goal"),
        pytest.param(
            [(BLUE, START), (BLUE, HALF_WAY), (NONE, HALF_WAY), (RED, HALF_WAY), (RED, HOME)], 1.0, id="handed over"
        ),
        pytest.param(
            [(RED, START), (RED, START), (NONE, START), (BLUE, START), (BLUE, HOME)], 0.0, id="held, not carried"
        ),
        pytest.param(
            [(RED, START), (RED, -1.0), (NONE, -1.0), (BLUE, -1.0), (BLUE, HOME)], 0.0, id="carried away by the partner"
        ),
        pytest.param(
            [(BLUE, START), (BLUE, HALF_WAY), (BOTH, HALF_WAY), (BLUE, HALF_WAY), (BLUE, HOME)], 0.0,
            id="touched without a way",
        ),
        pytest.param([(BLUE, START), (BLUE, 0.9), (BOTH, 0.9), (BOTH, HOME)], 1.0, id="help for the last bit"),
        pytest.param([(BOTH, START), (BOTH, HALF_WAY), (BLUE, HALF_WAY), (BLUE, HOME)], 1.0, id="help at the start"),
        pytest.param([(BLUE, START), (BLUE, HALF_WAY), (NONE, HALF_WAY)], None, id="not delivered"),
        pytest.param([(NONE, START), (NONE, HOME)], None, id="pushed home by nobody's hand"),
        pytest.param([(BLUE, START), (BLUE, HOME), (NONE, HOME), (BLUE, HOME), (BLUE, START)], None, id="taken out"),
    ],
)  # fmt: skip
def test_a_delivery_is_enabled_by_a_partner_who_brought_the_item_nearer(
    room: MapSpec, scene: Scene, share: float | None
) -> None:
    assert interdependence(room, scene) == share


def test_the_share_is_over_deliveries(room: MapSpec) -> None:
    states = states_of(room, [(BOTH, START), (BOTH, HOME), (NONE, HOME)])
    states.append(changed(states[-1], held=(1, -1)))
    states.append(changed(states[-1], held=(1, -1), items={1: (0.6, HOME, 0.0)}))
    metrics = EpisodeMetrics(room)
    metrics.update_episode(states, np.stack([STILL] * 5))
    assert metrics.result().interdependence == 0.5


def test_it_can_be_asked_after_every_tick_without_changing_the_end(room: MapSpec) -> None:
    states = states_of(room, [(BLUE, START), (BLUE, HALF_WAY), (BOTH, HALF_WAY), (BOTH, HOME), (NONE, HOME)])
    metrics, seen = EpisodeMetrics(room), []
    for before, after in pairwise(states):
        metrics.update(before, STILL, after)
        seen.append(metrics.result().interdependence)
    assert seen == [None, None, None, 1.0, 1.0]
