"""What the shipped agents decide stays as it was recorded in fixtures/shipped_decisions.json.

The states do not depend on the agents: the world is stepped with the actions in the file, and each agent, in each seat,
is asked before every tick. On a machine like the one that made the file (same packages and processor features) every
bit is equal; elsewhere networks round differently, and the decisions are equal within TOLERANCE.
"""

import hashlib
import json
import platform
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
import pytest

from movingout.agents.base import ActionChunk, EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.observation.seat_observation import observe
from movingout.maps import load_map
from movingout.maps.spec import SEAT_COLOURS
from movingout.world import World
from movingout.world.state import WorldState

RECORDED: dict[str, Any] = json.loads((Path(__file__).parent / "fixtures" / "shipped_decisions.json").read_text())
CPU_FEATURES = ("avx", "avx2", "fma", "avx512f", "avx512_vnni", "amx_tile")
TOLERANCE = 1e-5


def _machine() -> dict[str, object]:
    """What the bits of a network may depend on."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    features = next((line.split(":")[1].split() for line in lines if line.startswith("flags")), [])
    return {
        "machine": platform.machine(),
        "system": platform.system(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "onnxruntime": onnxruntime.__version__,
        "cpu_flags": [name for name in CPU_FEATURES if name in features],
    }


def _states() -> list[WorldState]:
    """The states before each tick."""
    world = World(load_map(RECORDED["map"]))
    states = []
    for row in RECORDED["actions"]:
        states.append(world.state())
        world.step(row)
    return states


def _answers(agent_id: str, seat: int) -> Iterator[ActionChunk]:
    """What an agent answers before each tick."""
    the_map = load_map(RECORDED["map"])
    agent = load_agent(agent_id)
    agent.reset(EpisodeInfo(the_map, seat, RECORDED["seed"], RECORDED["ticks"]))
    for state in _states():
        yield np.array(agent.act(observe(the_map, state, seat)), dtype=np.float64)


@pytest.mark.parametrize("agent_id", RECORDED["agents"])
@pytest.mark.parametrize("seat", [0, 1])
def test_a_shipped_agent_decides_as_recorded(agent_id: str, seat: int) -> None:
    recorded = RECORDED["agents"][agent_id][SEAT_COLOURS[seat]]
    answers = list(_answers(agent_id, seat))
    for decision in recorded["decisions"]:
        assert np.allclose(answers[decision["tick"]], decision["chunk"], rtol=0.0, atol=TOLERANCE)
    if _machine() == RECORDED["machine"]:
        hashes = [hashlib.sha256(np.ascontiguousarray(chunk).tobytes()).hexdigest()[:32] for chunk in answers]
        assert hashes == recorded["sha256_by_tick"]
