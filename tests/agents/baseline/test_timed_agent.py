"""An agent whose decisions are timed."""

import time
from pathlib import Path

import pytest

from movingout.agents import decision_time
from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.baseline.timed_agent import TimedAgent
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import load_map
from tests.agents.support import Forward


class _Silent(Forward):
    def act(self, observation: Observation) -> ActionChunk:  # type: ignore[empty-body]
        """Forgets to return."""


def _first(timed: TimedAgent) -> ActionChunk:
    the_map = load_map("HandOff")
    timed.reset(EpisodeInfo(the_map, 0, seed=0, ticks=10))
    return timed.act(observe(the_map, start_state(the_map), 0))


def test_an_answer_is_timed_and_given_as_far_as_it_is_to_be_played() -> None:
    timed = TimedAgent(Forward(4, 2))
    assert _first(timed).shape == (2, 4)
    assert len(timed.decisions_ms) == 1


def test_an_answer_that_is_no_chunk_is_refused_in_a_sentence() -> None:
    with pytest.raises(AgentError, match=r"act\(\) returned None; it returns an action chunk"):
        _first(TimedAgent(_Silent()))


def test_waiting_for_a_processor_that_others_keep_busy_is_no_time_of_a_decision(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    waited = tmp_path / "schedstat"

    class Hindered(Forward):
        def act(self, observation: Observation) -> ActionChunk:
            waited.write_text("0 750000000 2")
            return super().act(observation)

    waited.write_text("0 0 1")
    monkeypatch.setattr(decision_time, "_WAITED", waited)
    monkeypatch.setattr(time, "perf_counter", iter([10.0, 11.0]).__next__)
    timed = TimedAgent(Hindered(4, 2))
    _first(timed)
    assert timed.decisions_ms == [250.0]
