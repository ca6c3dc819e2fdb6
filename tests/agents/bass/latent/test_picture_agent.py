"""Policies and BASS that see pictures: trained, exported, played."""

import hashlib
from pathlib import Path

import numpy as np
import pytest
import torch

from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.latent.dynamics import LatentDynamics
from movingout.agents.bass.latent.picture_agent import PictureBassAgent
from movingout.agents.bass.latent.picture_networks import PictureDynamics, PictureProgress
from movingout.agents.bass.latent.picture_training import (
    picture_dynamics_spec,
    picture_sequences,
    train_picture_dynamics,
)
from movingout.agents.catalogue import load_agent
from movingout.agents.conformance import check_agent
from movingout.agents.errors import AgentError, DataError
from movingout.agents.kinds.policy import build_policy
from movingout.agents.policies.config import PolicyConfig
from movingout.server.cli import main
from tests.agents.learning import recorded, tiny_spec, walked

SEEN = tiny_spec(layout="image-v1", denoiser="cnn", obs_horizon=1)
TINY = BassConfig(score="tcl", width=8, latent=4, depth=4, batch=4, updates=2, progress_width=8, progress_latent=4)


def test_a_policy_that_sees_pictures_gives_chunks_and_reads_two_at_a_time() -> None:
    for count in (1, 2):
        policy = build_policy(tiny_spec(layout="image-v1", denoiser="cnn", obs_horizon=count))
        chunk = policy(torch.rand(3, count, 49152) * 255.0, torch.zeros(3, 1, 8, 5))
        assert chunk.shape == (3, 8, 5) and bool(chunk.isfinite().all())
        assert policy.mean.shape == (1,)


def test_pictures_and_their_network_go_together() -> None:
    for layout, denoiser in (("image-v1", "items"), ("image-v1", "resmlp"), ("aware-v1", "cnn")):
        with pytest.raises(DataError, match="--denoiser cnn and --layout image-v1 go together"):
            PolicyConfig(layout=layout, denoiser=denoiser).spec("dp")  # type: ignore[arg-type]
    with pytest.raises(DataError, match="--pose-noise is for layouts of numbers"):
        PolicyConfig(layout="image-v1", denoiser="cnn", pose_noise=0.002).check()


def test_the_simulator_of_pictures_draws_pictures_and_the_progress_embeds_them() -> None:
    dynamics = PictureDynamics(picture_dynamics_spec(TINY), (128, 128, 3))
    after = dynamics(torch.rand(2, 49152) * 255.0, torch.zeros(2, 4, 2, 4)).detach()
    assert after.shape == (2, 49152) and float(after.min()) >= 0.0 and float(after.max()) <= 255.0
    assert PictureProgress(TINY.progress_spec(), (128, 128, 3))(after).shape == (2, 4)


def test_a_residual_simulator_of_pictures_begins_with_no_change() -> None:
    dynamics = PictureDynamics(picture_dynamics_spec(TINY), (128, 128, 3))
    seen = torch.rand(2, 49152) * 255.0
    assert torch.allclose(dynamics(seen, torch.zeros(2, 4, 2, 4)), seen, atol=1e-3)


def test_films_have_the_own_action_first() -> None:
    walk = walked(ticks=12)
    sequences = picture_sequences([walk], SEEN)
    assert sequences.pictures.shape == (24, 49152) and sequences.starts.tolist() == [0, 12, 24]
    assert np.array_equal(sequences.actions[:12, 0], sequences.actions[12:, 1])
    with pytest.raises(DataError, match="no episode has more than 9 ticks"):
        picture_sequences([walked(ticks=9)], SEEN)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_simulator(tmp_path: Path) -> None:
    sequences = picture_sequences([walked(ticks=12)], SEEN)
    first, second = (train_picture_dynamics(TINY, sequences, tmp_path / name).network for name in "ab")
    assert _weights(first) == _weights(second)


@pytest.mark.parametrize("residual", [False, True])
def test_latent_dynamics_learns_what_actions_do(residual: bool) -> None:
    torch.manual_seed(0)
    model = LatentDynamics(
        lambda size: torch.nn.Linear(3, size), lambda: torch.nn.Linear(4, 3), 2, 32, 4, residual=residual
    )
    optimiser = torch.optim.Adam(model.parameters(), lr=0.01)
    found = []
    for _ in range(300):
        state, actions = torch.randn(64, 3), torch.randn(64, 2, 2)
        after = state + 0.5 * torch.nn.functional.pad(actions.sum(dim=1), (0, 1))
        losses = model.losses(state, actions, after)
        optimiser.zero_grad()
        losses["loss"].backward()  # type: ignore[no-untyped-call]
        optimiser.step()
        found.append(float(losses["prediction"].detach()))
    assert np.mean(found[-20:]) < 0.3 * found[0]


@pytest.mark.slow
def test_a_policy_and_bass_on_pictures_are_trained_exported_and_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    recorded(tmp_path / "demos", "one", ticks=12)
    few = ["--updates", "2", "--batch", "4", "--width", "16", "--evaluate-every", "2"]
    seeing = ["--layout", "image-v1", "--denoiser", "cnn"]
    assert main(["train", "dp", "demos", "--id", "dp@seen", *seeing, *few]) == 0
    on_it = ["train", "bass", "demos", "--base", "dp@seen", "--depth", "4", "--own", "2", "--partner", "2", *few]
    assert main([*on_it, "--id", "bass@no", "--score", "nfd"]) == 2
    assert "dp@seen sees pictures" in capsys.readouterr().err
    assert main([*on_it, "--id", "bass@seen", "--score", "tcl", "--progress-updates", "2"]) == 0
    agent = load_agent("bass@seen")
    assert isinstance(agent, PictureBassAgent)
    check_agent(lambda: load_agent("bass@seen"))
    assert main(["match", "--blue", "bass@seen", "--red", "dp@seen", "--map", "HandOff", "--ticks", "12"]) == 0
    with pytest.raises(AgentError, match="sees pictures: it takes simulator=learned"):
        load_agent("bass@seen:simulator=engine")


def _weights(network: torch.nn.Module) -> str:
    data = b"".join(tensor.numpy().tobytes() for tensor in network.state_dict().values())
    return hashlib.sha256(data).hexdigest()
