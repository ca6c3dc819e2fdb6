"""From recordings to an agent in a seat, with the commands a user types."""

import json
from pathlib import Path

import numpy as np
import pytest

from agents.base import EpisodeInfo
from agents.bass.recombination import LENGTH
from agents.checkpoint import find_checkpoint
from agents.chunk import checked_chunk
from agents.corrections import Lesson, save_correction, teach
from agents.observing import observe
from agents.serving import agent_of, agent_rows
from maps import load_map
from server.cli import main
from tests.agents.learning import recorded
from tests.agents.support import HERE
from world import World

TINY = ["--updates", "6", "--batch", "32", "--width", "16", "--depth", "1", "--evaluate-every", "3"]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    for number in range(3):
        recorded(folder, f"e{number}", ticks=30, seed=number, people=(f"p{number}", f"q{number}"))
    return folder


def test_training_writes_an_agent_that_plays(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["train", "dp", str(recordings), "--id", "dp@tiny", "--data", str(tmp_path), "--json", *TINY]) == 0
    assert json.loads(capsys.readouterr().out)["windows"] == 3 * 2 * 30
    card = find_checkpoint("dp@tiny", tmp_path / "models").card
    assert (card.training.episodes, card.maps, card.policy.width) == (3, ("HandOff",), 16)
    run = tmp_path / "runs" / "dp-tiny"
    assert json.loads((run / "config.json").read_text())["batch"] == 32
    assert list(run.glob("events.*"))

    agent = agent_of(find_checkpoint("dp@tiny", tmp_path / "models"))
    world = World(load_map("HandOff"))
    agent.reset(EpisodeInfo(world.map, 0, 1, 50))
    for _ in range(5):
        chunk = checked_chunk(agent.act(observe(world.map, world.state(), 0)))
        assert len(chunk) in (8, 7)  # decides every second tick and plays the rest of its plan in between
        row = chunk[0]
        world.step([[row[0], np.arctan2(row[2], row[1]), row[3]], [0, 0, 0]])


def test_augmentation_adds_windows_that_the_engine_confirmed(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", str(recordings), "--id", "mlp@more", "--data", str(tmp_path), *TINY, "--json"]
    assert main([*command, "--recombine", "0.5", "--pose-noise", "0.002"]) == 0
    captured = capsys.readouterr()
    assert "pieces valid" in captured.err
    assert json.loads(captured.out)["windows"] >= 180


def test_an_experts_labels_are_augmented_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ahead = f"{HERE}:Forward:distance=0.2"
    for number in range(2):
        lesson = Lesson(load_map("FourCorners"), ahead, ahead, (f"p{number}", "idle"), 1, seed=number, ticks=30)
        save_correction(tmp_path / f"{number}.corrections.npz", teach(lesson, slips=False))
    command = ["train", "mlp", str(tmp_path), "--id", "mlp@more", "--data", str(tmp_path), *TINY, "--json"]
    assert main([*command, "--recombine", "0.5"]) == 0
    captured = capsys.readouterr()
    assert "4 of 4 pieces valid" in captured.err
    assert json.loads(captured.out)["windows"] == 2 * 30 + 4 * LENGTH


def test_an_interrupted_training_goes_on_where_it_was(recordings: Path, tmp_path: Path) -> None:
    command = ["train", "mlp", str(recordings), "--id", "mlp@tiny", "--data", str(tmp_path), *TINY]
    assert main(command) == 0
    curve = tmp_path / "runs" / "mlp-tiny" / "losses.jsonl"
    assert [json.loads(line)["update"] for line in curve.read_text().splitlines()] == [3, 6]
    assert main([*command, "--updates", "9"]) == 0
    assert [json.loads(line)["update"] for line in curve.read_text().splitlines()] == [3, 6, 9]
    assert main([*command, "--width", "8"]) == 2  # the resume file is of another network


def test_recordings_of_another_format_are_refused_in_a_sentence(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("recordings.metadata.FORMAT_VERSION", 99)
    assert main(["train", "mlp", str(recordings), "--id", "mlp@tiny", "--data", str(tmp_path), *TINY]) == 2
    said = capsys.readouterr().err
    assert "e0.mcap" in said and "is not the format 99 of this program" in said and "Traceback" not in said


def test_the_same_seed_gives_the_same_weights(recordings: Path, tmp_path: Path) -> None:
    cards = []
    for place in ("one", "two"):
        folder = tmp_path / place
        assert main(["train", "mlp", str(recordings), "--id", "mlp@tiny", "--data", str(folder), *TINY]) == 0
        cards.append(find_checkpoint("mlp@tiny", folder / "models").card)
    assert cards[0].files == cards[1].files


def test_chunks_become_rows_with_unit_headings_and_presses_that_follow_the_hand() -> None:
    chunk = np.array([[2.0, 3.0, 4.0, -1, 1], [0.5, 0.0, 0.0, 1, -1]], dtype=np.float32)
    rows = agent_rows(chunk, holding=False, levels=True)
    assert np.allclose(rows, [[1.0, 0.6, 0.8, 1.0], [0.5, 1.0, 0.0, 1.0]])
    assert agent_rows(chunk, holding=True, levels=True)[:, 3].tolist() == [0.0, 1.0]
    assert agent_rows(chunk, holding=True, levels=False)[:, 3].tolist() == [1.0, 0.0]


def test_what_is_yes_or_no_is_told_so(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["train", "bass", "somewhere", "--base", "dp@all", "--rigid", "False"])
    assert "yes or no, not 'False'" in capsys.readouterr().err
