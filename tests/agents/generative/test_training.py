"""The model learns who plays: a partner that it is told plays otherwise than one that it is not told."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from movingout.agents.data.dataset import Indices, Singles, Windows
from movingout.agents.errors import DataError
from movingout.agents.generative.policy import LatentPolicy, Posterior
from movingout.agents.generative.training import episodes_of, train_latent
from tests.agents.generative.toy import TINY, windows


@pytest.mark.slow
def test_the_latent_of_an_episode_tells_two_partners_apart_and_explains_what_comes(tmp_path: Path) -> None:
    data = windows()
    fitted = train_latent(TINY.spec("latent"), TINY, data, tmp_path)
    *_, last = map(json.loads, (tmp_path / "losses.jsonl").read_text().splitlines())
    assert last["validation/own"] < 0.6 * last["validation/without"]
    assert last["validation/own"] < 0.4 * last["validation/another"]
    assert 0.2 < last["validation/divergence"] < 20.0

    rows = np.arange(24)
    with torch.inference_mode():
        means = [_mean_of_episode(fitted.network, data, number * 24 + rows) for number in range(4)]
    within, between = np.linalg.norm(means[0] - means[2]), np.linalg.norm(means[0] - means[1])
    assert between > 3 * within


def _mean_of_episode(network: LatentPolicy, data: Windows, rows: Indices) -> Singles:
    seen = torch.from_numpy(data.observations(rows, 1)).transpose(0, 1)
    chunk = torch.from_numpy(data.chunks(rows, TINY.horizon))[None]
    mean: Singles = network.encoder(network.encoded(seen), chunk).mean[0].numpy()
    return mean


def test_windows_of_a_batch_are_of_whole_episodes_and_none_comes_twice() -> None:
    data = windows(episodes=4)
    found = episodes_of(data, np.arange(48, 96))  # the last two
    assert found.first.tolist() == [48, 72] and found.lengths.tolist() == [24, 24]
    rows = found.drawn(2, 24, np.random.default_rng(0))
    assert sorted(rows.flatten().tolist()) == list(range(48, 96))
    assert all(len({row // 24 for row in one}) == 1 for one in rows.tolist())


def test_the_divergence_is_that_of_two_normal_distributions() -> None:
    mean, log_variance = torch.tensor([[1.0, -2.0], [0.0, 0.0]]), torch.tensor([[0.5, -1.0], [0.0, 0.0]])
    own = torch.distributions.Normal(mean, (0.5 * log_variance).exp())
    prior = torch.distributions.Normal(0.0, 1.0)
    expected = torch.distributions.kl_divergence(own, prior).sum(dim=1)
    assert torch.allclose(Posterior(mean, log_variance).divergence, expected)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"recombine": 0.5}, "leave out recombine"),
        ({"grasp": "toggle"}, "--grasp toggle: input should be 'hold'"),
        ({"episode_windows": 7}, "--episode-windows is an even number of at most --batch 64, not 7"),
        ({"episode_windows": 128}, "--episode-windows is an even number of at most --batch 64, not 128"),
        ({"beta": -1.0}, "--beta -1.0: input should be greater than or equal to 0"),
        ({"latent": 0}, "--latent 0: input should be greater than or equal to 1"),
    ],
)
def test_a_wrong_option_is_refused_with_a_sentence(changes: dict[str, object], sentence: str) -> None:
    with pytest.raises(DataError) as raised:
        replace(TINY, **changes).check()  # type: ignore[arg-type]
    assert sentence in str(raised.value)


def test_networks_that_a_latent_does_not_go_with_are_refused() -> None:
    with pytest.raises(DataError, match="a latent goes with --obs-horizon 1"):
        replace(TINY, layout="aware-v1", obs_horizon=2).spec("latent")
