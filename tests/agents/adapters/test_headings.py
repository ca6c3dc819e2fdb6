"""What headings of a policy's file are relative to: as in environments and exports of its layout."""

from pathlib import Path

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import load_map
from tests.agents.adapters.test_policy_file import onnx_file

MAP = load_map("FourCorners")  # blue looks along +x


@pytest.mark.parametrize(
    ("size", "options", "own"),
    [(383, "", True), (383, ",headings=arena", False), (121, "", False), (121, ",headings=own", True)],
)
def test_headings_are_in_the_frame_of_the_layout_unless_it_is_said(
    size: int, options: str, own: bool, tmp_path: Path
) -> None:
    """With `relative-v1` they were taken for the arena's."""
    agent = load_agent(f"onnx:path={onnx_file(tmp_path / 'p.onnx', size, rows=2)}{options}")
    agent.reset(EpisodeInfo(MAP, 0, seed=0, ticks=500))
    state = start_state(MAP)
    for tick, angle in enumerate((-1.5, 0.5)):  # each row turns with the robot as it stands in its tick
        state.robot_poses[0, 2] = angle
        expected = [np.cos(angle), np.sin(angle)] if own else [1.0, 0.0]
        np.testing.assert_allclose(agent.act(observe(MAP, state, 0, tick))[0, 1:3], expected, atol=1e-6)


def test_other_headings_are_refused(tmp_path: Path) -> None:
    with pytest.raises(AgentError, match="unknown headings 'blue'; known: own, arena"):
        load_agent(f"onnx:path={onnx_file(tmp_path / 'p.onnx', 121)},headings=blue")
