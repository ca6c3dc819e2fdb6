"""What researchers train with takes the environments: each stack in an environment of its own, from its constraints."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import ROOT

pytestmark = pytest.mark.slow
TORCH = "torch==2.13.0"


def installed(folder: Path, stack: str, *packages: str) -> Path:
    """The Python of a new environment with this project and the packages of a stack."""
    _run([sys.executable, "-m", "venv", str(folder / "venv")])
    python = folder / "venv" / "bin" / "python"
    constraints = str(ROOT / "constraints" / f"{stack}.txt")
    _run([str(python), "-m", "pip", "install", "--quiet", "-c", constraints, f"{ROOT}[env]", TORCH, *packages])
    return python


def test_stable_baselines_trains_one_seat_and_through_supersuit_both(tmp_path: Path) -> None:
    python = installed(tmp_path, "sb3", "stable-baselines3", "supersuit")
    said = _run([str(python), "-P", str(ROOT / "examples" / "train_sb3.py"), "512"])
    assert "one seat:  512 steps" in said
    assert "both seats: 512 steps" in said


def test_torchrl_rolls_out_past_the_end_of_an_episode(tmp_path: Path) -> None:
    python = installed(tmp_path, "torchrl", "torchrl")
    said = _run([str(python), "-P", str(ROOT / "examples" / "rollout_torchrl.py")])
    assert "both seats: 40 steps, 2 episodes ended" in said
    assert "one seat: 40 steps, 2 episodes ended" in said


def _run(command: list[str]) -> str:
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout[-2000:] + ran.stderr[-4000:]
    return ran.stdout
