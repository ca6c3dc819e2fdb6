"""Playing late on purpose."""

import numpy as np
import pytest

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.baseline.delayed_agent import DelayedAgent
from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.agents.partners.late_hands import LateHands
from movingout.maps import load_map

THE_MAP = load_map("HandOff")
EPISODE = EpisodeInfo(THE_MAP, 0, 0, 100)


class _Counting:
    """Says the tick it was asked for, in every row."""

    deterministic = True

    def __init__(self, rows: int) -> None:
        self.rows = rows
        self.asked: list[int] = []

    def reset(self, episode: EpisodeInfo) -> None:
        self.asked.clear()

    def act(self, observation: Observation) -> ActionChunk:
        self.asked.append(observation.tick)
        return np.array([[(observation.tick + 1 + row / 10) / 100, 1.0, 0.0, 0.0] for row in range(self.rows)])


def _play(agent: DelayedAgent, ticks: int) -> list[float]:
    agent.reset(EPISODE)
    return [round(100 * float(agent.act(observe(THE_MAP, start_state(THE_MAP), 0, t))[0, 0]), 3) for t in range(ticks)]


def test_with_lag_one_the_action_of_a_tick_was_decided_at_the_tick_before() -> None:
    assert _play(DelayedAgent(_Counting(1), 1), 4) == [0.0, 1.0, 2.0, 3.0]
    assert _play(DelayedAgent(_Counting(1), 3), 5) == [0.0, 0.0, 0.0, 1.0, 2.0]


def test_an_agent_that_plays_chunks_is_asked_no_more_often_than_without_lag() -> None:
    inner = _Counting(2)
    assert _play(DelayedAgent(inner, 1), 5) == [0.0, 1.0, 1.1, 3.0, 3.1]
    assert inner.asked == [0, 2, 4]


def test_any_agent_takes_the_option_lag() -> None:
    agent = load_agent("scripted:seed=3,lag=1")
    assert isinstance(agent, DelayedAgent) and agent.lag == 1
    assert not isinstance(load_agent("scripted:lag=0"), DelayedAgent)


def test_an_agent_that_is_not_deterministic_is_none_behind_lag_or_late_hands() -> None:
    """It passed `agents check` alone and failed with a lag."""
    inner = _Counting(1)
    assert DelayedAgent(inner, 1).deterministic and LateHands(inner).deterministic
    inner.deterministic = False
    assert not DelayedAgent(inner, 1).deterministic and not LateHands(inner).deterministic


@pytest.mark.parametrize("lag", ["-1", "11", "1.5", "much", "true"])
def test_a_lag_that_is_no_number_of_ticks_is_refused_in_a_sentence(lag: str) -> None:
    with pytest.raises(AgentError, match="whole number of ticks from 1 to 10"):
        load_agent(f"idle:lag={lag}")
