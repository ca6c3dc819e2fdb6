"""A training that cannot write says so; lines of what is learned again after it was stopped are there once."""

import json
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

from movingout.agents.errors import DataError
from movingout.agents.training.run_output import LOSSES, append_losses, cut_losses, save_tensors
from tests.recordings.full_disk import limited


def test_what_was_saved_stays_when_the_disk_is_full(tmp_path: Path) -> None:
    path = tmp_path / "resume.safetensors"
    save_tensors(path, {"a": torch.ones(3)})
    with (
        limited(200),
        pytest.raises(DataError, match=r"cannot write .*resume\.safetensors: .*the same command continues"),
    ):
        save_tensors(path, {"a": torch.zeros(3000)})
    assert load_file(path)["a"].tolist() == [1.0, 1.0, 1.0] and list(tmp_path.iterdir()) == [path]


def test_lines_beyond_what_is_gone_on_with_are_removed_and_so_is_one_that_was_cut_off(tmp_path: Path) -> None:
    cut_losses(tmp_path, "round", 2)
    for number in range(1, 5):
        append_losses(tmp_path, {"round": number, "loss": 0.5})
    append_losses(tmp_path, {"frames": 7.0})
    with limited((tmp_path / LOSSES).stat().st_size + 9), pytest.raises(DataError, match="cannot write"):
        append_losses(tmp_path, {"round": 5, "loss": 0.5})
    cut_losses(tmp_path, "round", 2)
    lines = (tmp_path / LOSSES).read_text(encoding="utf-8").splitlines()
    assert [json.loads(line) for line in lines] == [
        {"round": 1, "loss": 0.5},
        {"round": 2, "loss": 0.5},
        {"frames": 7.0},
    ]
