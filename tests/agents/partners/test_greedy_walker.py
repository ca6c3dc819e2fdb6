"""The greedy walker takes what is nearest, carries it home, and gives up after its patience."""

import pytest

from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import rollout
from movingout.agents.errors import AgentError
from movingout.agents.partners.greedy_walker import SHUNS_FOR, GreedyWalker
from movingout.agents.partners.walking import LOOSENS_FOR
from movingout.agents.scripted.perception import Perception
from movingout.maps import load_map
from movingout.world.scoring import delivered_items
from tests.agents.partners.scenes import holding, presses_after, scene, seated


def _chosen(order: str, map_name: str) -> int:
    agent = seated(GreedyWalker(order=order), map_name)
    assert isinstance(agent, GreedyWalker)
    return agent.choose(Perception(load_map(map_name), scene(map_name), 0))


def test_it_takes_the_nearest_the_farthest_or_the_kind_that_it_prefers() -> None:
    items = load_map("CornerDecision").items
    assert _chosen("near", "CornerDecision") != _chosen("far", "CornerDecision")
    assert items[_chosen("light", "CornerDecision")].size == "small"
    assert items[_chosen("heavy", "CornerDecision")].size != "small"


def test_it_lets_go_of_what_does_not_get_on_after_its_patience_and_leaves_it_alone_for_a_while() -> None:
    agent = seated(GreedyWalker(patience=20), "SingleRotation")
    let_go = presses_after(agent, "SingleRotation", holding("SingleRotation", 0), 60)
    assert 21 <= let_go <= 21 + (1 + 2) * LOOSENS_FOR  # two tries to get it loose
    assert isinstance(agent, GreedyWalker)
    the_map = load_map("SingleRotation")
    assert agent.choose(Perception(the_map, scene("SingleRotation", tick=let_go + 2), 0)) == -1
    assert agent.choose(Perception(the_map, scene("SingleRotation", tick=let_go + 2 + SHUNS_FOR), 0)) == 0


def test_alone_it_brings_small_items_home_on_a_map_without_walls_mirrored_or_not() -> None:
    for name in ("Simple", "Simple:mirror"):
        the_map = load_map(name)
        *_, last = rollout(the_map, (load_agent("greedy"), load_agent("idle")), 0, 400)
        assert delivered_items(the_map, last.after.item_poses).all()


def test_on_the_way_to_the_farthest_item_it_does_not_turn_round_for_the_one_that_is_farthest_then() -> None:
    steps = rollout(load_map("FourCorners"), (load_agent("greedy:order=far"), load_agent("idle")), 0, 150)
    assert any(step.after.held[0] >= 0 for step in steps)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ("order=nearest", "greedy: unknown order 'nearest'"),
        ("patience=2", "a whole number of ticks from 5 to 500, not 2"),
    ],
)
def test_a_wrong_option_is_refused(options: str, sentence: str) -> None:
    with pytest.raises(AgentError, match=sentence):
        load_agent(f"greedy:{options}")
