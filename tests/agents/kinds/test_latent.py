"""`movingout train latent`: from what partners did to a model of them."""

import json
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.checkpoint.checkpoint import find_checkpoint
from movingout.agents.data.corrections import load_correction, partner_samples, save_correction
from movingout.agents.data.dagger import LabellingJob, label_episode
from movingout.agents.observation.features import FeatureSet
from movingout.agents.partners.families import families
from movingout.maps import load_map
from movingout.server.cli import main
from tests.agents.learning import recorded
from tests.agents.support import HERE
from tests.agents.trained import load_checkpoint

AHEAD = f"{HERE}:Forward:distance=1.0"
TINY = [
    *("--updates", "3", "--batch", "32", "--episode-windows", "8", "--evaluate-every", "3"),
    *("--width", "16", "--depth", "1", "--latent", "3"),
]


@pytest.fixture
def labels(tmp_path: Path) -> Path:
    """Two files in which an expert drives ahead beside idle partners."""
    folder = tmp_path / "labels"
    folder.mkdir()
    for number in range(2):
        job = LabellingJob(load_map("HandOff"), AHEAD, AHEAD, (f"late0{number}", "idle"), number, number, 20)
        save_correction(folder / f"{number}.corrections.npz", label_episode(job))
    return folder


def test_training_writes_a_model_that_plays(labels: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recorded(tmp_path / "recordings", "e0", ticks=30)
    places = [str(labels), str(tmp_path / "recordings")]
    assert main(["train", "latent", *places, "--id", "latent@tiny", "--data", str(tmp_path), "--json", *TINY]) == 0
    trained = json.loads(capsys.readouterr().out)
    assert trained["windows"] == 2 * 20 + 2 * 30  # a seat of each file of labels, both of the recording
    checkpoint = find_checkpoint("latent@tiny", tmp_path / "models")
    assert (checkpoint.card.network.latent, checkpoint.card.network.lags) == (3, (3, 10, 30))
    assert vars(load_checkpoint(checkpoint, z="1/0/0"))["seed"] == 0
    curve = (tmp_path / "runs" / "latent-tiny" / "losses.jsonl").read_text().splitlines()
    assert {"divergence", "validation/own", "validation/without"} <= set(json.loads(curve[-1]))


def test_of_labels_the_partners_seat_is_learned(labels: Path) -> None:
    corrections = [load_correction(path) for path in sorted(labels.glob("*.npz"))]
    samples = list(partner_samples(corrections, FeatureSet("relative-v1")))
    assert [one.participant for one in samples] == ["late00", "late01"]
    assert all(np.all(one.targets[:, 0] == 0.0) and len(one.targets) == 20 for one in samples)  # idle


def test_a_latent_of_impossible_length_is_a_sentence(
    labels: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["train", "latent", str(labels), "--id", "latent@tiny", "--data", str(tmp_path), *TINY, "--latent", "65"]
    assert main(words) == 2
    assert "--latent 65: input should be less than or equal to 64" in capsys.readouterr().err


def test_a_family_draws_from_the_model_once_it_is_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("movingout.agents.partners.families.model_roots", lambda: (tmp_path,))
    assert families()["latent"].members == ()
    model = tmp_path / "latent-families"
    model.mkdir()
    (model / "card.json").write_text("{}")
    members = families()["latent"].members
    assert (members[2].name, members[2].agent_id) == ("latent03", "latent@families:seed=2")
