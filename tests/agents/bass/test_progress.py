"""Progress learned without rewards, and the simulator with code words."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from movingout.agents.bass.checkpoint_parts import packed_progress
from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.dynamics import QvaeDynamics, build_dynamics
from movingout.agents.bass.progress import LearnedProgress
from movingout.agents.bass.progress_training import NEAR, moments_of, train_progress
from movingout.agents.bass.state_vector import CONSTANT_WIDTH, MOVING_WIDTH, moving_arrays
from movingout.agents.catalogue import load_agent
from movingout.agents.checkpoint.card import DynamicsSpec
from movingout.agents.checkpoint.checkpoint import SHIPPED, find_checkpoint
from movingout.agents.errors import AgentError, DataError
from movingout.agents.inference.network import Network
from tests.agents.learning import walked

TINY = BassConfig(
    score="tcl", progress_width=16, progress_latent=4, progress_updates=120, batch=64, rate=3e-3, warmup=5, ema=0.9
)


def test_the_learned_distance_from_the_start_grows_with_time_and_is_exported_as_trained(tmp_path: Path) -> None:
    walk = walked(ticks=60)
    onward = np.linspace(0.0, 1.0, 61)[:, None]
    walk = dataclasses.replace(walk, item_poses=walk.item_poses + onward[..., None] * (1.0, 0.0, 0.0))
    network = train_progress(TINY, moments_of([walk] * 4), tmp_path).network
    files = packed_progress(network, find_checkpoint("dp@all", SHIPPED).card.training)
    progress, rows = LearnedProgress(files.spec, Network(files.onnx)), moving_arrays(*walk.state_arrays)
    distances = progress.distances(walk.map, rows)
    assert distances[0] == 0.0 and np.corrcoef(distances, np.arange(61))[0, 1] > 0.8
    early, late = progress.scores_of([(walk.map, 0)] * 2, [rows[1:3], rows[50:53]], 8)
    assert early.shape == (2,) and late.shape == (3,) and late.min() > early.max()


def test_episodes_without_near_and_far_moments_are_refused() -> None:
    with pytest.raises(DataError, match="no episode has more than 9 ticks"):
        moments_of([walked(ticks=NEAR + 1)])


def test_an_agent_without_the_embedding_cannot_choose_by_it() -> None:
    with pytest.raises(AgentError, match="bass@all has no progress network; train it with --score tcl"):
        load_agent("bass@all:score=tcl")


def test_code_words_take_the_place_of_latents_and_learn() -> None:
    torch.manual_seed(0)
    dynamics = build_dynamics(DynamicsSpec(kind="qvae", width=16, latent=8))
    assert isinstance(dynamics, QvaeDynamics)
    state, actions = torch.randn(32, MOVING_WIDTH), torch.randn(32, 8)
    constant = torch.zeros(32, CONSTANT_WIDTH)
    words, _ = dynamics.quantised(torch.randn(5, 8))
    known = {tuple(code) for code in dynamics.codes.detach().numpy().round(4).tolist()}
    assert {tuple(word) for word in words.detach().reshape(-1, 4).numpy().round(4).tolist()} <= known
    optimiser = torch.optim.Adam(dynamics.parameters(), lr=0.01)
    found = []
    for _ in range(40):
        losses = dynamics.losses(state, constant, actions, state + 0.1)
        optimiser.zero_grad()
        losses["loss"].backward()  # type: ignore[no-untyped-call]
        optimiser.step()
        found.append(float(losses["prediction"].detach()))
    assert found[-1] < 0.5 * found[0]
