"""With which words `movingout train` is called for an agent of the tables."""

from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import pytest
from safetensors import SafetensorError

from movingout.agents.bass.config import BassConfig
from movingout.agents.commands import train
from movingout.agents.kinds.bass import check_used
from movingout.agents.kinds.registry import KINDS
from movingout.agents.training.options import overridden
from movingout.maps.commands.parser import CommandParser
from movingout.matches.errors import MatchError
from movingout.matches.paper import training
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.methods import DATA_SETS, METHODS, trained_id
from movingout.matches.paper.training import LARGEST_SEED, training_seed, training_words
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.episode import SeatKind
from movingout.recordings.groups import grouped, write_groups
from tests.agents.learning import recorded

SMOKE = BUDGETS["smoke"]


def _words(agent: str, here: Path, kinds: tuple[str, str], **changes: object) -> list[str]:
    files = [recorded(here / f"theirs of {agent}", "one", people=("P1", "agent-b"), kinds=kinds)]  # type: ignore[arg-type]
    space = Workspace(budget=SMOKE, **changes)  # type: ignore[arg-type]
    write_groups(space.listing("c1"), grouped(files, 1))
    return [str(word) for word in training_words(trained_id(agent), space)]


def _said(words: list[str], option: str) -> str:
    return words[words.index(option) + 1] if option in words else ""


@pytest.mark.parametrize(
    ("agent", "kinds", "seats"),
    [("dp@c1", ("human", "agent"), "human"), ("dp@c1", ("agent", "agent"), ""), ("bass@c1", ("human", "agent"), "")],
)
def test_of_given_recordings_people_are_imitated_and_not_the_agents_that_they_played_with(
    agent: str, kinds: tuple[str, str], seats: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = _words(agent, tmp_path, kinds, given=(tmp_path,))
    assert _said(words, "--seats") == seats


def test_a_card_does_not_call_programs_people(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=SMOKE, given=(tmp_path,))
    human: tuple[SeatKind, SeatKind] = ("human", "human")
    people, programs = (recorded(tmp_path / f"{on}", f"{on}", simulated=on, kinds=human) for on in (False, True))
    agents = recorded(tmp_path / "agents", "agents", kinds=("agent", "agent"))
    for files, who in (
        ([people], "people of the given recordings"),
        ([programs], "simulated participants of the given recordings"),
        ([people, programs], "people and simulated participants of the given recordings"),
        ([agents], "agents of the given recordings"),
        ([agents, people], "people of the given recordings"),
    ):
        write_groups(space.listing("c1"), grouped(files, 1))
        assert _said([str(word) for word in training_words(trained_id("dp@c1"), space)], "--population") == who


def test_each_training_and_each_seed_of_the_command_has_a_seed_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    agents = "dp@c1", "dp@c1-2", "mappo-6@a", "mappo-6@b", "mappo-6@b-1"
    for seed, expected in ((0, ["0", "2", "0", "1", "3"]), (3, ["3000", "3002", "3000", "3001", "3003"])):
        words = [_words(agent, tmp_path / f"{seed}", ("agent", "agent"), seed=seed) for agent in agents]
        assert [_said(one, "--seed") for one in words] == expected


def test_a_date_is_a_seed_that_can_be_trained_with() -> None:
    seeds = [
        training_seed(number, Workspace(budget=SMOKE, seed=seed))
        for seed in (20261126, 20261127, LARGEST_SEED - 1, LARGEST_SEED)
        for number in range(8)
    ]
    assert len(set(seeds)) == len(seeds) and max(seeds) < 2**32


@pytest.mark.parametrize("budget", BUDGETS)
def test_every_agent_of_every_budget_can_be_asked_for(
    budget: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(training, "_files", lambda *_: [Path("one.mcap")])
    parser = CommandParser(prog="movingout train")
    train.configure(parser)
    space = Workspace(budget=BUDGETS[budget])
    for method in METHODS:
        for data in DATA_SETS:
            words = [str(word) for word in training_words(trained_id(f"{method}@{data}"), space)]
            args = parser.parse_args(words)
            config = overridden(KINDS[args.kind].presets[args.preset], args)
            config.check()
            if isinstance(config, BassConfig):
                check_used(config, args, {})


def test_who_learns_from_its_own_play_plays_varied_maps_for_the_second_challenge(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for evaluation, split in (("official", "official"), ("held-out", "train")):
        space = Workspace(budget=SMOKE, evaluation=evaluation)  # type: ignore[arg-type]
        words = [str(word) for word in training_words(trained_id("mappo-3@c2"), space)]
        assert _said(words, "--split") == split and _said(words, "--map") == "EfficientRoutes"
        assert "--split" not in training_words(trained_id("mappo-3@a"), space)


@pytest.mark.parametrize(
    ("agent", "budget", "said"),
    [
        ("dp@c1", "paper-size", {"--preset": "paper", "--updates": "6000", "--batch": "256"}),
        ("dp@c1", "paper-size", {"--process": "", "--sample-steps": ""}),
        ("gru@c1", "paper-size", {"--preset": "paper", "--updates": "6000", "--batch": "256"}),
        ("dp-image@c1", "full", {"--preset": "paper", "--updates": "", "--batch": "256"}),
        ("dp@c1", "full", {"--preset": "paper", "--updates": "", "--batch": ""}),
        ("dp-image@c1", "small", {"--preset": "fast", "--updates": "250", "--batch": "32"}),
        ("bass-tcl@c1", "full", {"--progress-updates": "8000", "--updates": ""}),
        ("bass@c1", "full", {"--progress-updates": "", "--updates": ""}),  # which its score does not learn with
        ("bass@c1", "small", {"--progress-updates": "", "--updates": "1000"}),
    ],
)
def test_budgets_say_how_long_and_in_which_batches_is_trained(
    agent: str, budget: str, said: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("movingout.matches.paper.training._files", lambda agent, space, maps: [])
    space = Workspace(budget=BUDGETS[budget])
    words = [str(word) for word in training_words(trained_id(agent), space)]
    assert {option: _said(words, option) for option in said} == said


def test_a_full_disk_is_said_in_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(training, "training_words", lambda agent, space: ["dp", "--id", agent.text])
    for error in (OSError(28, "No space left on device"), SafetensorError("No space left on device (os error 28)")):
        monkeypatch.setattr(train, "run", Mock(side_effect=error))
        with pytest.raises(MatchError, match=r"dp@c1 could not be trained in .*: .*No space left on device"):
            training.train_agent(trained_id("dp@c1"), Workspace(budget=SMOKE))


def test_ctrl_c_in_a_training_ends_the_whole_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(training, "training_words", lambda agent, space: ["dp", "--id", agent.text])
    monkeypatch.setitem(KINDS, "dp", replace(KINDS["dp"], train=Mock(side_effect=KeyboardInterrupt)))
    with pytest.raises(KeyboardInterrupt):
        training.train_agent(trained_id("dp@c1"), Workspace(budget=SMOKE))
    assert "stopped; the same command begins again" in next(training.LOGS.iterdir()).read_text()
