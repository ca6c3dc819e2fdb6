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


def test_a_look_takes_as_long_for_whoever_comes_second() -> None:
    (first, found), (second, same) = _look(PlacementCache()), _look(PlacementCache())
    assert first == second > 1
    assert same is found


def test_what_a_player_looked_into_itself_takes_no_time_again() -> None:
    placements = PlacementCache()
    assert [_look(placements)[0], _look(placements)[0]] == [_look(PlacementCache())[0], 1]


def test_a_terrain_that_somebody_has_is_the_same_however_many_others_there_were() -> None:
    mine = NOW.space()
    with_robot_on_it = with_robot(mine, NOW.pose)
    for column in range(200):
        with_robot(free_space(HAND_OFF, ((HAND_OFF.items[0], column / 100, 0.0, 0.0),)), NOW.pose)
    gc.collect()
    assert NOW.space() is mine
    assert with_robot(mine, NOW.pose) is with_robot_on_it
