"""The paper's own networks are trained for a few updates, exported and play."""

from pathlib import Path

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.observation.seat_observation import observe
from movingout.maps import load_map
from movingout.server.cli import main
from movingout.world import World
from tests.agents.learning import recorded

A_FEW = ["--preset", "paper", "--updates", "2", "--batch", "8", "--evaluate-every", "2", "--precision", "fp32"]

FEWER_STEPS = ["--sample-steps", "4"]
"""Instead of 36, each of which is a copy of the network in the exported graph: a minute and a half."""


@pytest.mark.slow
def test_each_kind_is_trained_with_the_papers_network(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    recordings = [str(recorded(tmp_path / "r", f"e{k}", 40, k, (f"a{k}", f"b{k}"))) for k in range(3)]
    the_map = load_map("HandOff")
    for kind, more in (("mlp", []), ("gru", []), ("dp", FEWER_STEPS), ("bass", ["--base", "dp@paper"])):
        assert main(["train", kind, "--id", f"{kind}@paper", *A_FEW, *more, *recordings]) == 0
        agent = load_agent(f"{kind}@paper")
        agent.reset(EpisodeInfo(the_map, 0, 0, 40))
        actions = agent.act(observe(the_map, World(the_map).state(), 0))
        assert len(actions) and np.isfinite(actions).all(), kind
