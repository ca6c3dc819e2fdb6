"""Scenes for partners: a state of a map with some fields changed, seen from a seat."""

from dataclasses import replace
from typing import Any

import numpy as np

from movingout.agents.base import ActionChunk, Agent, EpisodeInfo
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import load_map
from movingout.world.state import WorldState

BLUE, RED = 0, 1


def seated(agent: Agent, map_name: str, seat: int = BLUE, seed: int = 0) -> Agent:
    """The agent at the beginning of an episode."""
    agent.reset(EpisodeInfo(load_map(map_name), seat, seed, 500))
    return agent


def scene(map_name: str, **fields: Any) -> WorldState:
    """The start of a map with other `fields` of the state."""
    return replace(start_state(load_map(map_name)), **fields)


def asked(agent: Agent, map_name: str, state: WorldState, seat: int = BLUE) -> ActionChunk:
    """The agent's answer to a state."""
    return agent.act(observe(load_map(map_name), state, seat))


def holding(map_name: str, item: int, seat: int = BLUE, gap: float = 0.3, tick: int = 0) -> WorldState:
    """A seat that holds an item, from below it."""
    state = scene(map_name, tick=tick)
    poses, held = state.robot_poses.copy(), state.held.copy()
    poses[seat] = [state.item_poses[item, 0], state.item_poses[item, 1] - gap, 0.0]
    held[seat] = item
    return replace(state, robot_poses=poses, held=held)


def presses_after(agent: Agent, map_name: str, state: WorldState, ticks: int) -> int:
    """The tick at which the agent presses in a state that does not change, -1 for never."""
    for tick in range(ticks):
        if asked(agent, map_name, replace(state, tick=tick))[0, 3] > 0.5:
            return tick
    return -1


def heading(chunk: ActionChunk) -> float:
    """The heading [rad] of the first row, driven forward."""
    distance, cos, sin, _ = chunk[0].tolist()
    return float(np.arctan2(sin, cos) + (np.pi if distance < 0 else 0.0))
