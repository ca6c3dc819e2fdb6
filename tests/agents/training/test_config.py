"""What a training run may be told, as typed: everything else is refused before a recording is read."""

import argparse
from pathlib import Path

import pytest

from movingout.agents.checkpoint.card import MAX_NAME, MAX_POPULATION
from movingout.agents.kinds.registry import KINDS
from movingout.agents.training.options import add_fields, overridden
from movingout.server.cli import main


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("bass --base dp@all --combine foo", "--combine: unknown value 'foo'"),
        ("bass --base dp@all --score best", "--score: unknown value 'best'"),
        ("bass --base dp@all --dynamics lstm", "--dynamics: unknown value 'lstm'"),
        ("bass --base dp@all --order backwards", "--order: unknown value 'backwards'"),
        ("dp --process ddqm", "--process: unknown value 'ddqm'"),
        ("dp --layout map", "--layout: unknown value 'map'"),
        ("dp --grasp level", "--grasp: unknown value 'level'"),
        ("dp --denoiser transformer", "--denoiser: unknown value 'transformer'"),
        ("dp --matching none", "--matching: unknown value 'none'"),
        ("mlp --precision foo", "--precision: unknown value 'foo'"),
    ],
)
def test_a_wrong_word_is_answered_with_those_there_are(
    command: str, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["train", *command.split(), "nowhere"])
    said = capsys.readouterr().err
    assert stopped.value.code == 2
    assert sentence in said and "known: " in said and "Traceback" not in said


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("dp --batch 0", "--batch 0: input should be greater than or equal to 1"),
        ("dp --updates -5", "--updates -5"),
        ("dp --evaluate-every 0", "--evaluate-every 0"),
        ("dp --threads 0", "--threads 0"),
        ("dp --seed -1", "--seed -1"),
        ("dp --rate 0", "--rate 0.0"),
        ("dp --decay -0.1", "--decay -0.1"),
        ("dp --rate nan", "--rate nan"),
        ("dp --ema 1", "--ema 1.0"),
        ("dp --window-share 0", "--window-share 0.0"),
        ("dp --event-weight 0", "--event-weight 0"),
        ("dp --event-weight 4 --grasp toggle", "train with --grasp hold"),
        ("dp --width 100000", "--width 100000: input should be less than or equal to 4096"),
        ("dp --denoiser unet --horizon 6", "horizon 6 is to be a multiple of 4"),
        ("dp --denoiser unet --width 12", "width 12 of 8"),
        ("dp --denoiser items --layout map-v1", "other layouts take --denoiser resmlp"),
        ("dp --execute 9", "of a horizon of 8 actions 9 cannot be executed"),
        ("bass --base dp@all --own 0", "--own 0"),
        ("bass --base dp@all --value-width 1", "--value-width 1"),
        ("bass --base dp@all --discount 1.5", "--discount 1.5"),
        ("bass --base dp@all --order fine-tuned", "needs --residual no"),
        ("bass --base dp@all --order separate --dynamics gru", "--dynamics gru has none"),
        ("mlp --layout image-v1", "--layout image-v1 is for `train dp`"),
        ("bass --base dp@all --simulator bass@all --decay 0.1", "neither of which is learned; leave it out"),
        ("mlp --id mlp@all", "mlp@all ships with the package"),
        ("dp --id dp@any", "take --id dp@mine, or say --instead-of-shipped"),
        ("dp --id ../x", "'../x' is no id of a trained agent"),
        ("dp --id DP@mine", "such as dp@mine"),
        ("dp --id mine", "such as dp@mine"),
        (f"dp --name {'n' * (MAX_NAME + 1)}", f"the name has {MAX_NAME + 1} characters; {MAX_NAME} is the most"),
        (f"dp --population {'p' * (MAX_POPULATION + 1)}", "the population has"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence_before_a_recording_is_read(
    command: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["train", *command.split(), "nowhere", "--data", str(tmp_path)]) == 2
    (said,) = capsys.readouterr().err.splitlines()
    assert said.startswith("movingout: ") and sentence in said
    assert not list(tmp_path.iterdir())


def test_an_id_that_ships_is_trained_where_it_was_begun_and_where_that_is_meant(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", "nowhere", "--id", "mlp@all", "--data", str(tmp_path)]
    assert main([*command, "--instead-of-shipped"]) == 2
    (tmp_path / "runs" / "mlp-all").mkdir(parents=True, exist_ok=True)
    assert main(command) == 2
    said = capsys.readouterr().err
    assert said.count("nowhere") == 2 and "ships" not in said


def test_a_given_number_of_updates_is_in_place_of_the_presets_epochs() -> None:
    preset = KINDS["dp"].presets["paper"]
    parser = argparse.ArgumentParser()
    add_fields(parser, type(preset))
    assert overridden(preset, parser.parse_args([])).epochs == 1000
    changed = overridden(preset, parser.parse_args(["--updates", "50"]))
    assert (changed.updates, changed.epochs) == (50, 0)
    assert overridden(preset, parser.parse_args(["--updates", "50", "--epochs", "2"])).epochs == 2


def test_every_preset_can_be() -> None:
    for kind in KINDS.values():
        for config in kind.presets.values():
            config.check()
            if kind.name in ("mlp", "gru", "dp"):
                assert config.spec(kind.name).kind == kind.name


def test_only_kinds_for_which_the_paper_has_numbers_offer_its_preset(capsys: pytest.CaptureFixture[str]) -> None:
    assert {name for name, kind in KINDS.items() if "paper" not in kind.presets} == {"response", "self-play", "latent"}
    assert all(len(set(map(repr, kind.presets.values()))) == len(kind.presets) for kind in KINDS.values())
    with pytest.raises(SystemExit):
        main(["train", "self-play", "--preset", "paper", "--map", "HandOff"])
    assert "--preset: unknown value 'paper'; known: fast" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["mappo", "comedi", "response"])
def test_learning_by_playing_has_no_options_of_the_loop_that_it_does_not_use(kind: str) -> None:
    parser = argparse.ArgumentParser()
    add_fields(parser, type(KINDS[kind].presets["fast"]))
    known = {option for action in parser._actions for option in action.option_strings}
    assert known.isdisjoint({"--compile", "--precision", "--ema", "--warmup"}) and "--rate" in known
