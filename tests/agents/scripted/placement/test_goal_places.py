import gc

from movingout.agents.scripted.navigation.free_space import free_space, with_robot
from movingout.agents.scripted.navigation.sliced_planning import SlicedComputation
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.placement.goal_places import PlacementCache, Places
from movingout.maps import load_map
from movingout.world import World

HAND_OFF = load_map("HandOff")
NOW = Perception(HAND_OFF, World(HAND_OFF).state(), 0)


def _look(placements: PlacementCache) -> tuple[int, Places]:
    """How many slices a look takes, and what comes of it."""
    computation = SlicedComputation(placements.places(NOW.space((0,)), 0.08, NOW.remaining(0)))
    slices = 0
    while not computation.done:
        computation.advance(1)
        slices += 1
    return slices, computation.result


def test_an_evaluation_takes_a_second_agent_as_many_slices() -> None:
    (first, found), (second, same) = _look(PlacementCache()), _look(PlacementCache())
    assert first == second > 1
    assert same is found


def test_what_an_agent_evaluated_before_takes_no_slices() -> None:
    placements = PlacementCache()
    assert [_look(placements)[0], _look(placements)[0]] == [_look(PlacementCache())[0], 1]


def test_a_free_space_in_use_stays_the_same_object_however_many_others_are_made() -> None:
    mine = NOW.space()
    with_robot_on_it = with_robot(mine, NOW.pose)
    for column in range(200):
        with_robot(free_space(HAND_OFF, ((HAND_OFF.items[0], column / 100, 0.0, 0.0),)), NOW.pose)
    gc.collect()
    assert NOW.space() is mine
    assert with_robot(mine, NOW.pose) is with_robot_on_it
