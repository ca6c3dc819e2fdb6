"""BASS that simulates with the engine: trained without a simulator, played on any map."""

import argparse
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.engine_agent import EngineBassAgent
from movingout.agents.bass.loading import bass_agent
from movingout.agents.bass.state_vector import moving
from movingout.agents.checkpoint.checkpoint import find_checkpoint
from movingout.agents.data.rollout import SeatPlayer
from movingout.agents.errors import AgentError, DataError
from movingout.agents.kinds.bass import check_used
from movingout.agents.training.run_folder import CONFIG
from movingout.maps import load_map
from movingout.server.cli import main
from movingout.world import World
from tests.agents.learning import recorded

TINY = ["--updates", "4", "--batch", "32", "--width", "16"]


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of checkpoints with bass@tiny, which chooses by NFD and has no simulator of its own."""
    folder = tmp_path_factory.mktemp("engine")
    recorded(folder / "rec", "e0", ticks=20, seed=0)
    common = [str(folder / "rec"), "--data", str(folder), *TINY]
    assert main(["train", "dp", *common, "--id", "dp@tiny", "--horizon", "8", "--depth", "1"]) == 0
    engine = ["--base", "dp@tiny", "--dynamics", "engine", "--score", "nfd"]
    assert main(["train", "bass", "--data", str(folder), "--id", "bass@tiny", *engine]) == 0
    return folder / "models"


def test_nothing_is_learned_for_it_and_it_plays(models: Path) -> None:
    checkpoint = find_checkpoint("bass@tiny", models)
    assert [entry.name for entry in checkpoint.card.files] == ["policy.onnx"]
    assert checkpoint.card.dynamics is None
    agent = bass_agent(checkpoint)
    assert isinstance(agent, EngineBassAgent)
    world = World(load_map("generated:awareness:3"), record_sub_poses=False)
    player = SeatPlayer(agent, EpisodeInfo(world.map, 0, 0, 500))
    decisions = []
    for _ in range(10):
        world.step([player.action(world.state()), [0.0, 0.0, 0.0]])
        decisions += [agent.detail] if "scores" in agent.detail else []
    assert decisions
    assert all(np.array(one["scores"]).shape == (8,) for one in decisions)


def test_it_sees_what_will_be(models: Path) -> None:
    agent = bass_agent(find_checkpoint("bass@tiny", models))
    world = World(load_map("LeftRight"), record_sub_poses=False)
    agent.reset(EpisodeInfo(world.map, 0, 0, 500))
    chunk = np.tile(np.array([[0.9, 0.0, 1.0, 0.0], [0.9, 1.0, 0.0, 0.0]]), (8, 1, 1))
    world.step([[0.9, np.pi / 2, 0.0], [0.9, 0.0, 0.0]])
    (predicted,) = agent.simulator(world.state())(chunk[None])
    for _ in range(8):
        world.step([[0.9, np.pi / 2, 0.0], [0.9, 0.0, 0.0]])
    assert np.allclose(predicted[-1, :4], moving(world.state())[:4], atol=0.01)


def test_a_learned_simulator_is_not_asked_of_it(models: Path, capsys: pytest.CaptureFixture[str]) -> None:
    checkpoint = find_checkpoint("bass@tiny", models)
    with pytest.raises(AgentError, match="bass@tiny has no learned simulator; use simulator=engine"):
        bass_agent(checkpoint, simulator="learned")
    words = ["train", "bass", "--data", str(models.parent), "--id", "bass@two", "--base", "dp@tiny", "--score", "nfd"]
    assert main([*words, "--simulator", "bass@all", "--dynamics", "engine"]) == 2
    assert "is for a learned simulator, not for --dynamics engine" in capsys.readouterr().err
    assert main([*words, "--simulator", "bass@tiny"]) == 2
    assert "bass@tiny has no learned simulator" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ("--dynamics engine --width 16", "--width is for a learned simulator, not for --dynamics engine; leave it out"),
        ("--progress-updates 3", "--progress-updates is for --score tcl, not for --score value; leave it out"),
        (
            "--dynamics engine --updates 9",
            "--updates is for a learned simulator, not for --dynamics engine; leave it out",
        ),
        ("--score nfd --value-updates 3", "--value-updates is for --score value, not for --score nfd; leave it out"),
        *(
            (f"--simulator bass@any {option}", f"{option.split()[0]} is for a simulator that is trained, not for --sim")
            for option in ("--width 16", "--rigid no", "--dynamics gru", "--order joint", "--updates 9", "--epochs 2")
        ),
        ("--value bass@any --discount 0.9", "--discount is for a value network that is trained, not for --value bass@"),
    ],
)
def test_options_that_would_do_nothing_are_refused(
    models: Path, options: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["train", "bass", str(models.parent / "rec"), "--data", str(models.parent), "--id", "bass@new"]
    assert main([*words, "--base", "dp@tiny", *options.split()]) == 2
    assert told in capsys.readouterr().err


def test_a_training_that_began_with_such_options_goes_on() -> None:
    options = argparse.Namespace(width=16, progress_width=64, simulator="", value="")
    config = BassConfig(dynamics="engine", width=16, progress_width=64)
    check_used(config, options, {"width": 16, "progress_width": 64})
    with pytest.raises(DataError, match="--progress-width is for --score tcl"):
        check_used(config, options, {"width": 16, "progress_width": 128})


def test_a_training_goes_on_whose_simulator_another_has_with_other_sizes_of_its_own(
    models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Tables said sizes that did nothing, and now leave them out: a training that was cut off could not go on."""
    shutil.copytree(models, tmp_path / "models")
    words = ["train", "bass", str(models.parent / "rec"), "--data", str(tmp_path), "--id", "bass@new", "--batch", "8"]
    words += ["--base", "dp@tiny", "--simulator", "bass@all", "--score", "tcl", "--progress-width", "8"]
    assert main([*words, "--progress-updates", "2"]) == 0
    file = tmp_path / "runs" / "bass-new" / CONFIG
    file.write_text(json.dumps(json.loads(file.read_text()) | {"width": 256, "value_width": 64}))
    assert main([*words, "--progress-updates", "3"]) == 0, capsys.readouterr().err
    assert json.loads(file.read_text())["width"] == BassConfig.width


def test_half_the_engine_steps_show_nearly_the_same(models: Path) -> None:
    checkpoint = find_checkpoint("bass@tiny", models)
    state = World(load_map("LeftRight"), record_sub_poses=False).state()
    chunk = np.tile(np.array([[0.9, 0.0, 1.0, 0.0], [0.9, 1.0, 0.0, 0.0]]), (1, 8, 1, 1))
    seen = {}
    for sub_steps in (20, 10):
        agent = bass_agent(checkpoint, sub_steps=sub_steps)
        agent.reset(EpisodeInfo(load_map("LeftRight"), 0, 0, 500))
        seen[sub_steps] = agent.simulator(state)(chunk)[0, :, :2]
    assert not np.array_equal(seen[20], seen[10])
    assert np.allclose(seen[20], seen[10], atol=0.03)
    with pytest.raises(AgentError, match="sub_steps is one of 20, 10, not 15"):
        bass_agent(checkpoint, sub_steps=15)
