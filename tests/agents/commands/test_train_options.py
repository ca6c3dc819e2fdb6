"""The options of `movingout train`: what is refused, and what their examples and helps say."""

import json
import shlex
from pathlib import Path

import pytest

from movingout.agents.checkpoint.checkpoint import find_checkpoint
from movingout.maps import load_map, map_from_json, map_to_json
from movingout.maps.commands.parser import parsers_below
from movingout.server.cli import configured, main
from tests.agents.learning import recorded

TINY = ["--updates", "6", "--batch", "32", "--width", "16", "--depth", "1", "--evaluate-every", "3"]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    for number in range(3):
        recorded(folder, f"e{number}", ticks=30, seed=number, people=(f"p{number}", f"q{number}"))
    return folder


@pytest.mark.parametrize("kind", ["response", "mappo", "comedi"])
def test_the_example_of_what_learns_from_its_own_play_names_no_recordings(kind: str) -> None:
    _, parser = configured("train")
    [example] = [one.epilog for one in parsers_below(parser) if one.prog.endswith(f" {kind}")]
    words = shlex.split(str(example).removeprefix("example: movingout train "))
    assert parser.parse_args(words).recordings == []


@pytest.mark.parametrize("kind", ["response", "mappo", "comedi"])
def test_the_help_of_what_learns_from_its_own_play_has_only_options_that_apply(kind: str) -> None:
    _, parser = configured("train")
    [help_text] = [one.format_help() for one in parsers_below(parser) if one.prog.endswith(f" {kind}")]
    for word in ("recordings", "--manifest", "--group", "--without", "--epochs", "--held-out", "--window-share"):
        assert word not in help_text, word
    assert "--seed" in help_text and "--rate" in help_text


@pytest.mark.parametrize(
    ("kind", "option"),
    [
        ("mappo", "--updates"),
        ("bass --base dp@all", "--window-share"),
        *(("latent", option) for option in ("--window-share", "--recombine", "--event-weight", "--matching")),
        *((kind, option) for kind in ("mlp", "gru") for option in ("--dropout", "--denoiser", "--sample-steps")),
    ],
)
def test_an_option_that_a_training_does_not_use_is_unknown_to_it(
    kind: str, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["train", *kind.split(), option, "3"])
    assert f"unknown option {option}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            ["--layout", "relative-v1", "--lags", "3,x"],
            "--lags 3,x: numbers of ticks joined by commas are needed, such as 3,10,30",
        ),
        (["--group", "2"], "--group 2 is of the list that --manifest names; name it, too"),
        (["--data", "taken"], "cannot write taken/runs/dp-mine: Not a directory"),
    ],
)
def test_wrong_options_are_refused_with_what_is_needed(
    options: list[str],
    sentence: str,
    recordings: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("a file")
    assert main(["train", "dp", str(recordings), *TINY, *options]) == 2
    assert sentence in capsys.readouterr().err


def test_options_that_shape_the_network_are_those_of_the_agent_at_the_start(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", str(recordings), "--data", str(tmp_path)]
    own_frame = ["--layout", "relative-v1", "--lags", "3,10"]
    assert main([*command, "--id", "mlp@base", *TINY, *own_frame]) == 0
    more = [*command, "--id", "mlp@more", "--start", "mlp@base", "--updates", "1", "--batch", "32"]
    for typed, has in (("--layout aware-v1", "relative-v1"), ("--lags 5", "3,10"), ("--execute 4", "2")):
        assert main([*more, *typed.split()]) == 2
        sentence = f"{typed}: the network is that of --start mlp@base, which has {has}; leave it out"
        assert sentence in capsys.readouterr().err
    assert main([*more, "--pose-noise", "0.002"]) == 2
    assert "leave it out with relative-v1" in capsys.readouterr().err
    assert not (tmp_path / "runs" / "mlp-more").exists()

    assert main([*more, *own_frame, "--width", "16"]) == 0
    path = tmp_path / "runs" / "mlp-more" / "config.json"
    used = json.loads(path.read_text())
    assert (used["layout"], used["lags"], used["width"], used["depth"]) == ("relative-v1", "3,10", 16, 1)
    path.write_text(json.dumps({**used, "layout": "aware-v1", "width": 512}))  # as earlier versions wrote it
    assert main([*more, "--updates", "2"]) == 0
    assert json.loads(path.read_text())["width"] == 16


def test_episodes_too_short_for_a_value_are_refused_before_the_simulator_is_trained(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "bass", str(recordings), "--data", str(tmp_path), "--base", "dp@all", "--id", "bass@tiny"]
    assert main([*command, "--updates", "2", "--width", "8", "--latent", "2", "--batch", "8"]) == 2
    said = capsys.readouterr().err
    assert "no episode has more than 60 ticks" in said and "--score nfd" in said and "training" not in said
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize("kind", ["mlp", "latent", "bass --base dp@all"])
def test_a_recording_of_a_map_that_is_not_seen_is_named_before_anything_is_trained(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    goals = [{"x0": x, "y0": 1.2, "x1": x + 0.35, "y1": 0.8} for x in (-1.2, -0.75, -0.3, 0.15, 0.6)]
    five = map_from_json(map_to_json(load_map("Simple")) | {"name": "Five", "goals": goals})
    file = recorded(tmp_path / "own", "five", the_map=five, ticks=80)
    assert main(["train", *kind.split(), str(tmp_path / "own"), "--data", str(tmp_path), "--id", "own@five"]) == 2
    said = capsys.readouterr().err
    assert f"{file}: the layout " in said and "has 4 slots for goals; Five has 5; leave it out" in said
    assert not (tmp_path / "runs").exists()


def test_what_is_yes_or_no_is_told_so(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["train", "bass", "somewhere", "--base", "dp@all", "--rigid", "False"])
    assert "yes or no, not 'False'" in capsys.readouterr().err


def test_a_card_says_how_many_episodes_are_of_people_without_a_name(tmp_path: Path) -> None:
    for number, people in enumerate((("ann", "bob"), ("", ""), ("", ""))):
        recorded(tmp_path / "mixed", f"e{number}", ticks=20, seed=number, people=people, kinds=("human", "human"))
    assert main(["train", "mlp", str(tmp_path / "mixed"), "--id", "mlp@mixed", "--data", str(tmp_path), *TINY]) == 0
    card = find_checkpoint("mlp@mixed", tmp_path / "models").card
    assert card.training.population == "2 participants and people without a name (2 episodes)"
    assert card.description == f"MLP trained on 3 episodes of {card.training.population}."
