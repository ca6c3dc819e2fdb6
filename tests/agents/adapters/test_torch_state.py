"""A policy of torch that draws: from the seed of its episode, whatever is played beside it; nobody else's numbers."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import torch

from movingout.agents.adapters.torch_state import TorchState
from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.conformance import check_agent
from movingout.agents.environment.seat_env import SeatEnv
from movingout.maps import load_map
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.match import Match


class Noise(torch.nn.Module):
    def forward(self, seen: torch.Tensor) -> torch.Tensor:
        return torch.cat((torch.ones(seen.shape[0], 1), torch.randn(seen.shape[0], 3)), 1)


@pytest.fixture
def agent_id(tmp_path: Path) -> str:
    with pytest.warns(DeprecationWarning):
        torch.jit.save(torch.jit.script(Noise()), str(tmp_path / "noise.pt"))
    return f"torchscript:path={tmp_path / 'noise.pt'},layout=official-v1"


@pytest.fixture
def _two_threads() -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    yield
    torch.set_num_threads(before)


def test_matches_that_draw_are_the_same_alone_and_side_by_side(agent_id: str) -> None:
    matches = [Match("HandOff", "idle", agent_id, seed, ticks=6) for seed in range(4)]
    together = {result.match: result.play_hash for result in Lockstep().play(matches)}
    alone = {result.match: result.play_hash for result in Lockstep(batch_size=1).play(reversed(matches))}
    assert together == alone
    assert len(set(alone.values())) == len(matches)


def test_a_policy_that_draws_keeps_the_contract(agent_id: str) -> None:
    check_agent(lambda: load_agent(agent_id), maps=["HandOff"], ticks=5)


@pytest.mark.usefixtures("_two_threads")
def test_a_learner_keeps_its_random_numbers_and_threads_beside_such_a_partner(agent_id: str) -> None:
    torch.manual_seed(123)
    expected = torch.rand(2).tolist()
    torch.manual_seed(123)
    env = SeatEnv(partner=agent_id, limit_ticks=5)
    env.reset(seed=5)
    env.step(np.array([0, 1, 0, 0], dtype=np.float32))
    assert torch.rand(2).tolist() == expected
    assert torch.get_num_threads() == 2


@pytest.mark.usefixtures("_two_threads")
def test_it_decides_on_one_thread_and_an_error_leaves_nothing_behind() -> None:
    state = TorchState()
    state.reset(EpisodeInfo(load_map("HandOff"), 0, seed=1, ticks=5))
    before = torch.get_rng_state()
    with pytest.raises(ValueError, match="of the policy"), state.in_use():
        torch.rand(1)
        assert torch.get_num_threads() == 1
        raise ValueError("of the policy")
    assert torch.equal(torch.get_rng_state(), before)
    assert torch.get_num_threads() == 2
