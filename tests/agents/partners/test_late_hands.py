"""Late hands play an agent's actions some ticks later, unsteadily, and press once where the agent presses again."""

import numpy as np
import pytest

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.partners.late_hands import LateHands
from movingout.world.state import Floats
from tests.agents.partners.scenes import asked, scene, seated


class _Counting:
    """Its distance tells the tick; it presses from tick 2 on."""

    def reset(self, episode: EpisodeInfo) -> None:
        pass

    def act(self, observation: Observation) -> ActionChunk:
        return np.array([[observation.tick / 100, 1.0, 0.0, float(observation.tick >= 2)]])


def _played(ticks: int = 12, **options: float | bool) -> Floats:
    agent = seated(LateHands(_Counting(), **options), "Simple")  # type: ignore[arg-type]
    return np.array([asked(agent, "Simple", scene("Simple", tick=tick))[0] for tick in range(ticks)])


def test_what_was_decided_is_played_so_many_ticks_later(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("movingout.agents.partners.late_hands.LAG_CHANGES", 0.0)
    rows = _played(delay=3, jitter=0.0)
    assert rows[:, 0].tolist() == pytest.approx([0, 0, 0, *(tick / 100 for tick in range(9))])


def test_a_press_is_not_repeated_before_its_effect_can_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("movingout.agents.partners.late_hands.LAG_CHANGES", 0.0)
    assert np.flatnonzero(_played(20, delay=3, jitter=0.0)[:, 3]).tolist() == [5, 11, 17]


def test_the_lag_varies_and_the_steering_too_but_equal_seeds_play_the_same() -> None:
    one, same, other = (_played(60, delay=3, jitter=0.3, seed=seed) for seed in (1, 1, 2))
    assert (one == same).all() and (one != other).any()
    assert np.arctan2(one[:, 2], one[:, 1]).std() > 0.05
    lags = np.arange(60) - np.rint(100 * one[:, 0])
    assert len(set(lags[10:].tolist())) > 1


def test_slips_drive_somewhere_else_for_a_while() -> None:
    assert np.unique(np.rint(100 * _played(100, delay=0, jitter=0.0)[:, 0])).size == 100
    assert np.unique(np.rint(100 * _played(100, delay=0, jitter=0.0, slips=0.1)[:, 0])).size < 100


def test_keys_have_full_speed_or_none() -> None:
    assert set(_played(40, delay=1, keys=True)[:, 0].tolist()) <= {-1.0, 0.0, 1.0}


@pytest.mark.parametrize(
    ("agent_id", "sentence"),
    [
        ("late:delay=11", "delay is a whole number of ticks from 0 to 10, not 11"),
        ("late:seed=x", "seed is a whole number, not 'x'"),
        ("late:jitter=2", "jitter lies between 0 and 1.0, not 2"),
        ("late:agent=late", "'late' has late hands already; give its options to late"),
        ("late:agent=nobody", "unknown agent 'nobody'"),
        ("clone:policy=greedy", "clone: policy is the id of a trained agent, such as dp@all, not 'greedy'"),
    ],
)
def test_what_cannot_be_is_refused_with_a_sentence(agent_id: str, sentence: str) -> None:
    with pytest.raises(AgentError) as raised:
        load_agent(agent_id)
    assert sentence in str(raised.value)


def test_options_of_the_agent_inside_are_joined_by_semicolons() -> None:
    agent = load_agent("late:agent=greedy:order=far;patience=40,delay=2")
    assert isinstance(agent, LateHands)
    assert (agent.delay, vars(agent.agent)["order"], vars(agent.agent)["patience"]) == (2, "far", 40)
