"""What researchers train with takes the environments: each stack in an environment of its own, from its constraints."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import ROOT

pytestmark = [pytest.mark.slow, pytest.mark.timeout(2400)]  # installations take minutes, on busy machines many
TORCH = "torch==2.13.0"
PICTURES = """
import sys, gymnasium, movingout
from gymnasium.wrappers import FlattenObservation
from stable_baselines3 import PPO
from movingout.matches import play
env = gymnasium.make("MovingOut-v1", partner="idle", layout="image-v1", limit_ticks=20)
for policy, seen in (("CnnPolicy", env), ("MlpPolicy", FlattenObservation(env))):
    PPO(policy, seen, n_steps=16, batch_size=16, n_epochs=1).learn(16).save(sys.argv[1])
    result, = play("idle", f"sb3:path={sys.argv[1]}", map="HandOff", ticks=3)
    print(policy, "played", result.ticks, "ticks from pictures")
"""
RESCALED = """
import sys, gymnasium, movingout
from gymnasium.wrappers import RescaleAction
from stable_baselines3 import PPO
from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.observation.seat_observation import observe, start_state
model = PPO("MlpPolicy", RescaleAction(gymnasium.make("MovingOut-v1", partner="idle"), -1, 1), seed=0)
model.policy.action_net.bias.data[3] = 0.3  # a press, where the grasp goes from -1 to 1
model.save(sys.argv[1])
agent, the_map = load_agent(f"sb3:path={sys.argv[1]}"), movingout.load_map("HandOff")
agent.reset(EpisodeInfo(the_map, 0, seed=0, ticks=5))
print("grasp", agent.act(observe(the_map, start_state(the_map), 0))[0, 3])
"""


@pytest.fixture(scope="module")
def with_torch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with torch alone, which takes longest to install and is the same for every stack."""
    folder = tmp_path_factory.mktemp("torch") / "venv"
    _run([sys.executable, "-m", "venv", str(folder)])
    python = str(folder / "bin" / "python")
    _run([python, "-m", "pip", "install", "--quiet", TORCH])
    _run([python, "-c", "import torch"])  # compiles what each stack needs of it
    return folder


def installed(with_torch: Path, folder: Path, stack: str, *packages: str) -> Path:
    """The Python of a copy of that environment, with this project and the packages of a stack."""
    # A link to each file will do: pip replaces files, it does not write into them.
    shutil.copytree(with_torch, folder / "venv", symlinks=True, copy_function=os.link)
    python = folder / "venv" / "bin" / "python"
    constraints = str(ROOT / "constraints" / f"{stack}.txt")
    _run([str(python), "-m", "pip", "install", "--quiet", "-c", constraints, f"{ROOT}[env]", TORCH, *packages])
    return python


def test_stable_baselines_trains_one_seat_and_through_supersuit_both(with_torch: Path, tmp_path: Path) -> None:
    python = installed(with_torch, tmp_path, "sb3", "stable-baselines3", "supersuit")
    model = tmp_path / "ppo.zip"
    said = _run([str(python), "-P", str(ROOT / "examples" / "train_sb3.py"), "512", str(model)])
    assert "one seat:  512 steps" in said
    assert "both seats: 512 steps" in said
    seat = [str(python), "-P", "-m", "movingout.server.cli", "match", "--red", f"sb3:path={model}", "--blue", "idle"]
    assert "ppo.zip" in _run([*seat, "--map", "HandOff", "--ticks", "20"])
    said = _run([str(python), "-P", "-c", PICTURES, str(tmp_path / "pictures.zip")])
    for policy in ("CnnPolicy", "MlpPolicy"):
        assert f"{policy} played 3 ticks from pictures" in said
    assert "grasp 1.0" in _run([str(python), "-P", "-c", RESCALED, str(tmp_path / "rescaled.zip")])


def test_torchrl_rolls_out_past_the_end_of_an_episode(with_torch: Path, tmp_path: Path) -> None:
    python = installed(with_torch, tmp_path, "torchrl", "torchrl")
    said = _run([str(python), "-P", str(ROOT / "examples" / "rollout_torchrl.py")])
    assert "both seats: 40 steps, 2 episodes ended" in said
    assert "one seat: 40 steps, 2 episodes ended" in said


@pytest.mark.timeout(10800)  # the installation alone: a quarter of an hour on two cores, 91 minutes on overloaded ones
@pytest.mark.large_download  # its torch brings gigabytes of CUDA libraries
def test_lerobot_trains_from_an_export_and_what_it_trained_takes_a_seat(tmp_path: Path) -> None:
    _run([sys.executable, "-m", "venv", str(tmp_path / "venv")])
    python = str(tmp_path / "venv" / "bin" / "python")
    constraints = str(ROOT / "constraints" / "lerobot.txt")
    _run([python, "-m", "pip", "install", "--quiet", "-c", constraints, f"{ROOT}[export,video]", "lerobot"])
    movingout = [python, "-P", "-m", "movingout.server.cli"]
    recordings, numbers, pictures = (str(tmp_path / name) for name in ("recordings", "numbers", "pictures"))
    _run([*movingout, "match", "--red", "scripted", "--blue", "scripted", "--ticks", "60", "--record", recordings])
    _run([*movingout, "recordings", "export", recordings, "--to", "lerobot", "--out", numbers])
    _run([*movingout, "recordings", "export", recordings, "--to", "lerobot", "--out", pictures, "--images", "96"])
    for data, kind in ((numbers, "act"), (numbers, "diffusion"), (pictures, "diffusion")):
        out = f"{data}-{kind}"
        said = _run([python, "-P", str(ROOT / "examples" / "train_lerobot.py"), data, kind, out, "1"])
        assert "observation.environment_state" in said and "1 steps" in said
        assert ("observation.images.view" in said) == (data == pictures)
        seat = ["match", "--red", f"lerobot:path={out}", "--blue", "idle", "--map", "HandOff", "--ticks", "12"]
        assert "lerobot:path=" in _run([*movingout, *seat])


def test_benchmarl_trains_both_seats_for_some_iterations(with_torch: Path, tmp_path: Path) -> None:
    python = installed(with_torch, tmp_path, "benchmarl", "benchmarl")
    said = _run([str(python), "-P", str(ROOT / "examples" / "train_benchmarl.py"), "2000"])
    assert "iteration 2: reward per tick" in said
    assert "2000 steps of MAPPO" in said


def test_rllib_builds_an_algorithm_and_trains_it(with_torch: Path, tmp_path: Path) -> None:
    python = installed(with_torch, tmp_path, "rllib", "ray[rllib]")
    said = _run([str(python), "-P", str(ROOT / "examples" / "train_rllib.py"), "1"])
    assert "iteration 1: return" in said


def _run(command: list[str]) -> str:
    own = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}  # not this source tree
    own["RAY_ADDRESS"] = "local"  # nor a cluster of tests beside it, which ends before this does
    ran = subprocess.run(command, env=own, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout[-2000:] + ran.stderr[-4000:]
    return ran.stdout
