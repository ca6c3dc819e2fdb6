"""Whatever a training was interrupted by, the card of its agent names what was learned from, and nothing else."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from movingout.agents.checkpoint.card import OTHER_MAPS, Card
from movingout.agents.checkpoint.checkpoint import CARD, find_checkpoint
from movingout.agents.data.dataset import data_hash
from movingout.agents.training import fit
from movingout.agents.training.learned_data import LEARNED
from movingout.agents.training.run import PEOPLE
from movingout.agents.training.run_folder import CONFIG, RESUME
from movingout.maps import load_map
from movingout.maps.randomize import pair_text, pairs_on
from movingout.recordings.episode import SeatKind
from movingout.server.cli import main
from tests.agents.learning import recorded

pytestmark = pytest.mark.slow

MAPS = {"a": "HandOff", "b": "FourCorners", "c": "LeftRight"}
TINY = ["--batch", "32", "--width", "16", "--depth", "1", "--evaluate-every", "3", "--held-out", "0"]
Train = Callable[..., int]


@pytest.fixture
def train(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Train:
    """Trains mlp@tiny on a folder, with one map each; or is interrupted after, or before, the first resume file."""
    for seed, (name, on) in enumerate(MAPS.items()):
        recorded(tmp_path / name, name, ticks=65, seed=seed, the_map=load_map(on))
    save = fit._save

    def trained(name: str, updates: int, *options: str, interrupted: str = "") -> int:
        def save_or_not(*args: Any) -> None:
            if interrupted != "before":
                save(*args)
            if interrupted:
                raise KeyboardInterrupt

        monkeypatch.setattr(fit, "_save", save_or_not)
        own = ["--id", "mlp@tiny", "--data", str(tmp_path), "--updates", str(updates)]
        return main(["train", "mlp", str(tmp_path / name), *own, *TINY, *options])

    return trained


def card(data: Path) -> Card:
    return find_checkpoint("mlp@tiny", data / "models").card


def items(*names: str) -> frozenset[str]:
    return frozenset(pair_text(pair) for name in names for pair in pairs_on(load_map(MAPS[name])))


def maps(*names: str) -> tuple[str, ...]:
    return tuple(sorted(MAPS[name] for name in names))


def as_before(run: Path) -> None:
    """The run folder of a version that did not keep what was learned, nor who counts as whom."""
    config = json.loads((run / CONFIG).read_text())
    del config[LEARNED], config[PEOPLE]
    (run / CONFIG).write_text(json.dumps(config))


@pytest.mark.parametrize("first", ["done", "interrupted"])
def test_data_of_an_interrupted_training_stay_on_the_card(train: Train, tmp_path: Path, first: str) -> None:
    assert train("a", 6, interrupted="" if first == "done" else "after") == (0 if first == "done" else 130)
    assert train("b", 12, "--go-on", interrupted="after") == 130
    assert train("c", 14, "--go-on") == 0
    assert (card(tmp_path).maps, card(tmp_path).learned_items) == (maps("a", "b", "c"), items("a", "b", "c"))
    assert card(tmp_path).description.endswith(", and on others before.")
    assert train("c", 16) == 0
    assert card(tmp_path).learned_items == items("a", "b", "c")


@pytest.mark.parametrize(("interrupted", "how"), [("after", "goes on from what was saved last"), ("before", "begins")])
def test_an_interrupted_training_says_what_the_same_command_does(
    train: Train, capsys: pytest.CaptureFixture[str], interrupted: str, how: str
) -> None:
    assert train("a", 6, interrupted=interrupted) == 130
    assert f"movingout: stopped; the same command {how}" in capsys.readouterr().err


def test_one_that_is_ended_by_the_same_command_still_names_others_before(train: Train, tmp_path: Path) -> None:
    assert train("a", 6, interrupted="after") == 130
    assert train("b", 12, "--go-on", interrupted="after") == 130
    assert train("b", 12) == 0
    assert (card(tmp_path).maps, card(tmp_path).learned_items) == (maps("a", "b"), items("a", "b"))
    assert card(tmp_path).description.endswith(", and on others before.")


def test_one_that_held_out_others_of_the_same_people_goes_on_only_on_purpose(
    train: Train, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "runs" / "mlp-tiny" / CONFIG
    for name, people in (("d", ("P1", "dp")), ("e", ("P2", "dp"))):
        recorded(tmp_path / "mixed", name, ticks=65, people=people, kinds=("human", "agent"))
    share = "--held-out", "0.5"
    assert train("mixed", 6, *share) == 0 == train("mixed", 7, *share)
    written = json.loads(config.read_text(encoding="utf-8"))
    without = {name: value for name, value in written.items() if name != PEOPLE}
    for updates, before in ((8, without), (9, {**written, PEOPLE: "0" * 64})):
        config.write_text(json.dumps(before), encoding="utf-8")
        assert train("mixed", updates, *share) == 2
        assert "learned from people who would be held out for validation now" in capsys.readouterr().err
        assert json.loads(config.read_text(encoding="utf-8")) == before
        assert train("mixed", updates, *share, "--go-on") == 0
        assert "learned from people who are held out for validation now" in capsys.readouterr().err
        assert json.loads(config.read_text(encoding="utf-8"))[PEOPLE] == written[PEOPLE]


@pytest.mark.parametrize(
    ("people", "kinds", "seats", "code"),
    [
        (("", ""), ("human", "human"), "acting", 2),
        (("P1", "dp"), ("human", "agent"), "human", 0),
        (("P1", ""), ("human", "idle"), "acting", 0),
        (("P1", "P2"), ("human", "human"), "all", 0),
    ],
)
def test_an_older_run_is_refused_only_where_it_learned_from_seats_that_count_otherwise(
    train: Train, tmp_path: Path, people: tuple[str, str], kinds: tuple[SeatKind, SeatKind], seats: str, code: int
) -> None:
    for name in "de":
        recorded(tmp_path / "mixed", name, ticks=65, seed=ord(name), people=people, kinds=kinds)
    options = "--held-out", "0.5", "--seats", seats
    assert train("mixed", 3, *options) == 0
    as_before(tmp_path / "runs" / "mlp-tiny")
    assert train("mixed", 4, *options) == code


def test_older_folders_say_that_they_do_not_know(train: Train, tmp_path: Path) -> None:
    run = tmp_path / "runs" / "mlp-tiny"
    assert train("a", 6) == 0
    as_before(run)
    assert train("b", 8, "--go-on") == 0
    assert (card(tmp_path).maps, card(tmp_path).learned_items) == (maps("a", "b"), items("a", "b")), "its card says it"
    assert train("c", 14, "--go-on", interrupted="after") == 130
    as_before(run)
    assert train("b", 16, "--go-on") == 0
    assert (card(tmp_path).maps, card(tmp_path).learned_items) == ((*maps("a", "b"), OTHER_MAPS), None)


def test_a_damaged_card_in_the_run_folder_does_not_end_a_training(train: Train, tmp_path: Path) -> None:
    run = tmp_path / "runs" / "mlp-tiny"
    assert train("a", 6) == 0
    for agent_is_there in (True, False):
        as_before(run)
        (run / CARD).write_text('{"schema_version": 1, "id"')
        if not agent_is_there:
            (tmp_path / "models" / "mlp-tiny" / CARD).write_text("{")
        assert train("a", 8) == 0
        assert card(tmp_path).learned_items == (items("a") if agent_is_there else None)
    assert card(tmp_path).maps == (*maps("a"), OTHER_MAPS)
    assert (run / CARD).read_bytes() == (tmp_path / "models" / "mlp-tiny" / CARD).read_bytes()


def test_what_nothing_was_learned_from_is_not_on_the_card(train: Train, tmp_path: Path) -> None:
    assert train("a", 6, interrupted="before") == 130
    assert train("b", 6) == 0
    assert (card(tmp_path).maps, card(tmp_path).learned_items) == (maps("b"), items("b"))
    assert "before" not in card(tmp_path).description
    (tmp_path / "runs" / "mlp-tiny" / RESUME).unlink()
    assert train("c", 6) == 0, "it begins anew"
    assert (card(tmp_path).maps, card(tmp_path).learned_items) == (maps("c"), items("c"))
    assert "before" not in card(tmp_path).description


def test_a_run_that_was_begun_on_copies_is_gone_on_with(train: Train, tmp_path: Path) -> None:
    shutil.copy(tmp_path / "a" / "a.mcap", tmp_path / "a" / "copy.mcap")
    run = tmp_path / "runs" / "mlp-tiny"
    assert train("a", 6) == 0
    as_before(run)
    config = json.loads((run / CONFIG).read_text())
    only = config["data_sha256"]
    config["data_sha256"] = data_hash([tmp_path / "a" / "a.mcap", tmp_path / "a" / "copy.mcap"])
    (run / CONFIG).write_text(json.dumps(config))
    assert only != config["data_sha256"]
    assert train("a", 8) == 0
    assert (card(tmp_path).maps, card(tmp_path).learned_items) == (maps("a"), items("a"))
    assert card(tmp_path).training.data_sha256 == only and "before" not in card(tmp_path).description
    assert train("a", 10) == 0


def bass(data: Path, name: str, *options: str) -> int:
    own = ["--id", "bass@tiny", "--data", str(data), "--batch", "8", "--width", "8", "--latent", "2", *options]
    return main(["train", "bass", str(data / name), *own])


def simulated(data: Path) -> tuple[str, ...] | None:
    training = find_checkpoint("bass@tiny", data / "models").card.dynamics_training
    assert training is not None
    return training.items


@pytest.mark.parametrize("is_older", [False, True])
def test_bass_names_no_items_of_a_policy_that_it_had_before(train: Train, tmp_path: Path, is_older: bool) -> None:
    for name in "ab":
        assert train(name, 3, "--id", f"mlp@{name}") == 0
    assert bass(tmp_path, "c", "--base", "mlp@a", "--score", "nfd", "--updates", "2") == 0
    if is_older:
        as_before(tmp_path / "runs" / "bass-tiny")
    assert bass(tmp_path, "c", "--base", "mlp@b", "--score", "nfd", "--updates", "2") == 0
    assert simulated(tmp_path) == tuple(sorted(items("c")))
    assert bass(tmp_path, "a", "--base", "mlp@b", "--score", "nfd", "--updates", "3", "--go-on") == 0
    assert simulated(tmp_path) == tuple(sorted(items("a", "c")))


def test_what_the_simulator_has_learned_from_stays_when_the_value_has_no_updates_left(
    train: Train, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert train("a", 3) == 0
    small = ["--base", "mlp@tiny", "--value-width", "8", "--value-updates", "3"]
    assert bass(tmp_path, "a", *small, "--updates", "2") == 0
    assert bass(tmp_path, "b", *small, "--updates", "3", "--go-on") == 2
    assert "give a larger --value-updates" in capsys.readouterr().err
    assert bass(tmp_path, "a", *small, "--updates", "4", "--value-updates", "4") == 2, "it goes on with b"
    assert bass(tmp_path, "a", *small, "--updates", "4", "--value-updates", "4", "--go-on") == 0
    assert simulated(tmp_path) == tuple(sorted(items("a", "b")))
