"""A real question to the model of an agent, before it is relied on: in play, its fallback covers every fault."""

import warnings
from typing import NamedTuple

from movingout.agents.base import Agent, EpisodeInfo, Wrapper
from movingout.agents.llm.agent import SILENT, LlmAgent
from movingout.agents.llm.model_id import USEFUL
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import load_map
from movingout.maps.files.terminal import printable
from movingout.world.constants import LIMIT_TICKS


class FirstAnswer(NamedTuple):
    """What came of the question, for a terminal: `problem` is empty where the answer can be played."""

    latency_s: float
    plan: str
    problem: str


def first_answer(agent: Agent, map_name: str) -> FirstAnswer | None:
    """Ask about the start of a map; None for an agent that asks no model.

    It asks again as in play, within the time-out of the agent each time: a server may load its model then.
    """
    while isinstance(agent, Wrapper):
        agent = agent.agent
    if not isinstance(agent, LlmAgent):
        return None
    spec = load_map(map_name)
    agent.reset(EpisodeInfo(spec, 0, 0, LIMIT_TICKS))
    for _ in range(SILENT):
        with warnings.catch_warnings(action="ignore"):  # that its fallback plays
            told = agent.ask_and_wait(observe(spec, start_state(spec), 0))
        if useful := agent.episode_counts.get(USEFUL, 0):
            break
    return FirstAnswer(
        float(str(told["latency_s"])), printable(agent.plan), "" if useful else printable(str(told["note"]))
    )
