"""The agents that the documentation shows must be ones that work."""

import pickle
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from movingout.agents.base import EpisodeInfo
from movingout.agents.conformance import check_agent
from movingout.agents.observation.seat_observation import observe
from movingout.maps import load_map
from movingout.world import World
from movingout.world.action import to_world
from tests.support import ROOT


def test_the_documented_agent_keeps_the_rules_and_drives_to_the_first_item() -> None:
    text = (ROOT / "docs" / "learning.md").read_text(encoding="utf-8")
    names: dict[str, type] = {}
    exec(text.split("## Your own agent")[1].split("```python")[1].split("```")[0], names)
    check_agent(names["MyPolicy"])
    the_map = load_map("FourCorners")
    world, agent = World(the_map), names["MyPolicy"]()
    agent.reset(EpisodeInfo(the_map, 0, 0, 10))
    away = []
    for _ in range(5):
        state = world.state()
        away.append(float(np.hypot(*(state.item_poses[0, :2] - state.robot_poses[0, :2]))))
        world.step(to_world([agent.act(observe(the_map, state, 0))[0], np.array([0.0, 1.0, 0.0, 0.0])]))
    assert away[-1] < away[0] - 0.05


class Model:
    """Predicts as models of scikit-learn do, beyond the range of an action."""

    def predict(self, rows: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.tile([1.2, 1.0, 0.0, 0.3], (len(rows), 1)) + 0.01 * rows[:, :1]


def test_the_documented_class_plays_a_pickled_model(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "agents.md").read_text(encoding="utf-8")
    names: dict[str, type] = {}
    exec(text.split("`mine:Pickled:path=policy.pkl`")[1].split("```python")[1].split("```")[0], names)
    file = tmp_path / "policy.pkl"
    file.write_bytes(pickle.dumps(Model()))
    check_agent(partial(names["Pickled"], file))
