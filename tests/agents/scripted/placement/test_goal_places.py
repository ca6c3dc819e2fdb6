import gc

from movingout.agents.scripted.navigation.sliced_planning import Thinking
from movingout.agents.scripted.navigation.terrain import terrain, with_robot
from movingout.agents.scripted.placement.goal_places import Looks, Places
from movingout.agents.scripted.situation import Situation
from movingout.maps import load_map
from movingout.world import World

HAND_OFF = load_map("HandOff")
NOW = Situation(HAND_OFF, World(HAND_OFF).state(), 0)


def _look(looks: Looks) -> tuple[int, Places]:
    """How many slices a look takes, and what comes of it."""
    thinking = Thinking(looks.places(NOW.ground((0,)), 0.08, NOW.outlook(0)))
    slices = 0
    while not thinking.done:
        thinking.advance(1)
        slices += 1
    return slices, thinking.result


def test_a_look_takes_as_long_for_whoever_comes_second() -> None:
    (first, found), (second, same) = _look(Looks()), _look(Looks())
    assert first == second > 1
    assert same is found


def test_what_a_player_looked_into_itself_takes_no_time_again() -> None:
    looks = Looks()
    assert [_look(looks)[0], _look(looks)[0]] == [_look(Looks())[0], 1]


def test_a_terrain_that_somebody_has_is_the_same_however_many_others_there_were() -> None:
    mine = NOW.ground()
    crowded = with_robot(mine, NOW.pose)
    for column in range(200):
        with_robot(terrain(HAND_OFF, ((HAND_OFF.items[0], column / 100, 0.0, 0.0),)), NOW.pose)
    gc.collect()
    assert NOW.ground() is mine
    assert with_robot(mine, NOW.pose) is crowded
