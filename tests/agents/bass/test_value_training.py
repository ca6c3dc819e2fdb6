"""What a value is learned from, and that it is learned."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from movingout.agents.bass.checkpoint_parts import packed_value, value_of
from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.state_vector import moving_arrays
from movingout.agents.bass.value import Value
from movingout.agents.bass.value_training import (
    TAIL,
    Returns,
    discounted,
    returns_of,
    train_value,
)
from movingout.agents.checkpoint.checkpoint import SHIPPED, find_checkpoint
from movingout.agents.errors import CheckpointError, DataError
from movingout.agents.inference.network import Network
from movingout.maps import load_map
from tests.agents.learning import walked


def test_later_progress_is_worth_less() -> None:
    assert discounted(np.array([0.0, 0.0, 1.0]), 0.5).tolist() == [0.25, 0.5, 1.0]


def test_states_near_an_end_that_time_made_are_left_out() -> None:
    short, long = (walked("HandOff", ticks=ticks) for ticks in (TAIL, TAIL + 5))
    data = returns_of([long, short], 0.98)
    assert len(data.returns) == 2 * 5 and set(data.episodes.tolist()) == {0}
    with pytest.raises(DataError, match="no episode has more than 60 ticks"):
        returns_of([short], 0.98)


def test_an_episode_in_which_all_was_delivered_counts_to_its_end() -> None:
    trajectory = walked("SingleRotation", ticks=20)
    the_map = load_map("SingleRotation")
    goal = the_map.goals[0]
    items = trajectory.item_poses.copy()
    items[-1, 0, :2] = (goal.left + goal.right) / 2, (goal.bottom + goal.top) / 2
    data = returns_of([dataclasses.replace(trajectory, item_poses=items)], 0.5)
    assert len(data.returns) == 2 * 20
    assert data.returns[19] > 0.4  # half of the way and all of the completion, in the last tick
    assert data.returns[18] == pytest.approx(data.returns[19] / 2, abs=0.05)


@pytest.mark.slow
def test_a_value_tells_what_follows_and_is_exported_as_trained(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    features = random.standard_normal((4000, 278)).astype(np.float16)
    data = Returns(features, 0.1 * features[:, 3].astype(np.float32), np.arange(4000) // 100, (frozenset(),) * 40)
    config = BassConfig(value_width=16, value_members=2, value_updates=300, batch=128, rate=3e-3, warmup=10, ema=0.98)
    network = train_value(config, data, tmp_path).network
    rows = features[900:1000].astype(np.float32)  # the tenth episode is not trained on
    source = find_checkpoint("dp@all", SHIPPED).card.training
    files = packed_value(network, source)
    assert (files.spec, files.training) == (config.value_spec(), source)
    (served,) = Network(files.onnx)(features=rows)
    assert np.corrcoef(served, data.returns[900:1000])[0, 1] > 0.9
    with torch.inference_mode():
        assert np.allclose(served, network(torch.from_numpy(rows)).numpy(), atol=1e-3)
        both = torch.from_numpy(np.stack([rows, rows]))
        assert np.allclose(served, network.each(both).mean(dim=0), atol=0.02), "the value is the mean of its members"
        assert not torch.equal(network.each(both)[0], network.each(both)[1])
    assert files.spec.members == 2


def test_a_value_in_the_own_frame_tells_each_members_mind_and_mirrors(tmp_path: Path) -> None:
    trajectory = walked("HandOff", ticks=TAIL + 20)
    data = returns_of([trajectory] * 10, 0.98, "relative-v1")
    config = BassConfig(
        value_width=16, value_members=3, value_updates=2, batch=32, value_layout="relative-v1", caution=1.0
    )
    network = train_value(config, data, tmp_path).network
    files = packed_value(network, find_checkpoint("dp@all", SHIPPED).card.training)
    assert (files.spec.layout, files.spec.each) == ("relative-v1", True)
    value = Value(files.spec, Network(files.onnx))
    rows = moving_arrays(*trajectory.state_arrays)[:5]
    (scores,) = value.scores_of([(trajectory.map, 0)], [rows], 8)
    assert scores.shape == (5, 3)
    with pytest.raises(DataError, match="--value-layout is aware-v1 and relative-v1, not map-v1"):
        BassConfig(value_layout="map-v1").check()


def test_the_value_of_an_agent_without_one_cannot_be_taken() -> None:
    with pytest.raises(CheckpointError, match="dp@all has no value network"):
        value_of(find_checkpoint("dp@all", SHIPPED))
