"""The novice makes a beginner's mistakes, and fewer of them later."""

from dataclasses import replace

import pytest

from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.partners.novice import LATEST, Novice
from movingout.agents.scripted.perception import Perception
from movingout.world.state import WorldState
from tests.agents.partners.scenes import asked, holding, presses_after, scene, seated


def _drops(from_tick: int) -> int:
    """In how many of 30 episodes a carried item is let go within two seconds, from a tick on."""
    count = 0
    for seed in range(30):
        agent = seated(Novice(seed), "PassOrSplit", seed=seed)
        state = holding("PassOrSplit", 0)
        asked(agent, "PassOrSplit", replace(state, tick=from_tick))
        pressed = [asked(agent, "PassOrSplit", replace(state, tick=from_tick + k))[0, 3] > 0.5 for k in range(1, 20)]
        count += any(pressed)
    return count


def test_it_lets_go_too_early_and_less_often_later() -> None:
    early, late = _drops(0), _drops(2000)
    assert early >= 6 and late < early / 2


def test_after_a_press_it_may_press_again_at_once() -> None:
    twice = 0
    for seed in range(30):
        agent = seated(Novice(seed), "SingleRotation", seed=seed)
        state = holding("SingleRotation", 0)
        first = presses_after(agent, "SingleRotation", state, 120)
        empty = replace(state, tick=first + 1, held=scene("SingleRotation").held)
        twice += first >= 0 and asked(agent, "SingleRotation", empty)[0, 3] > 0.5
    assert 3 <= twice <= 20


def test_it_pulls_elsewhere_at_first_in_some_episodes() -> None:
    elsewhere = 0
    for seed in range(20):
        agent = seated(Novice(seed), "FourCorners", seed=seed)
        asked(agent, "FourCorners", holding("FourCorners", 0))
        assert isinstance(agent, Novice)
        elsewhere += agent._astray_until > 0
    assert 4 <= elsewhere <= 16


def test_it_sees_the_partner_late_at_first_and_feels_its_own_hand_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    agent = seated(Novice(learns_in=10**6), "PassOrSplit")
    assert isinstance(agent, Novice)
    seen: list[WorldState] = []
    perceive = agent._perceiver.perceive

    def noted(state: WorldState) -> Perception:
        seen.append(state)
        return perceive(state)

    monkeypatch.setattr(agent._perceiver, "perceive", noted)
    for tick in range(10):
        asked(agent, "PassOrSplit", scene("PassOrSplit", tick=tick))
    asked(agent, "PassOrSplit", holding("PassOrSplit", 0, tick=10))
    assert [state.tick for state in seen[-3:]] == [8 - LATEST, 9 - LATEST, 10]


def test_a_wrong_option_is_refused() -> None:
    with pytest.raises(AgentError, match="novice: learns_in is a whole number of ticks from 1"):
        load_agent("novice:learns_in=0")
