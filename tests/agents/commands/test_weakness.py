"""`movingout agents weakness`: the partners of a model with which an agent does worst."""

import json
from pathlib import Path

import pytest

from movingout.agents.base import ActionChunk, Observation
from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.catalogue import load_agent
from movingout.agents.errors import AgentError
from movingout.agents.generative.trials import Occasion, Trial, completion
from movingout.server.cli import main
from tests.agents.generative.toy import MODEL, untrained

SMALL = [
    *("--map", "Simple", "--episodes", "2", "--ticks", "6", "--workers", "1"),
    *("--rounds", "2", "--candidates", "4", "--worst", "2"),
]


@pytest.fixture(autouse=True)
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    untrained(tmp_path / "data" / "models")


def test_it_names_partners_that_can_play(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "worst" / "partners.txt"
    assert main(["agents", "weakness", "greedy", "--partner", MODEL, *SMALL, "-o", str(out)]) == 0
    printed = capsys.readouterr()
    assert "round 2 of 2: gain" in printed.err and "2 drawn at random" in printed.out
    ids = out.read_text().splitlines()
    assert len(ids) == 2 and all(name.startswith(f"{MODEL}:z=") for name in ids)
    for name in ids:
        load_agent(name)


def test_a_file_that_cannot_be_written_is_named_before_anything_is_played(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    command = ["agents", "weakness", "greedy", "--partner", MODEL, *SMALL, "-o"]
    assert main([*command, str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert printed.err == f"movingout: cannot write {tmp_path}: Is a directory\n" and not printed.out
    earlier = tmp_path / "partners.txt"
    earlier.write_text("kept\n")
    monkeypatch.setattr("movingout.agents.commands.weakness.search", _broken_off)
    for out in (earlier, tmp_path / "new.txt"):
        assert main([*command, str(out)]) == 2
    assert earlier.read_text() == "kept\n" and not (tmp_path / "new.txt").exists()


def _broken_off(*_: object) -> None:
    raise AgentError("broken off")


def test_equal_seeds_find_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["agents", "weakness", "idle", "--partner", MODEL, *SMALL, "--minimise", "tcr", "--seed", "3", "--json"]
    found = []
    for _ in range(2):
        assert main(command) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert found[0] == found[1] and len(found[0]["worst"]) == len(found[0]["random"]) == 2
    assert all(one["tcr"] == one["idle"] for one in found[0]["worst"])  # the agent is idle itself


def test_all_partners_play_on_the_same_occasions() -> None:
    occasion = Occasion(("HandOff", "Simple"), 4, 50)
    one, other = (occasion.trials("idle", partner, 7) for partner in ("greedy", "porter"))
    assert [(t.map, t.seat, t.seed) for t in one] == [(t.map, t.seat, t.seed) for t in other]
    assert {(t.map, t.seat) for t in one} == {(name, seat) for name in ("HandOff", "Simple") for seat in (0, 1)}


def test_an_episode_scores_what_was_delivered() -> None:
    assert completion(Trial("idle", "greedy", "Simple", 1, 0, 400)) == 1.0
    assert completion(Trial("idle", "idle", "Simple", 0, 0, 5)) == 0.0


class Leaving(IdleAgent):
    def act(self, observation: Observation) -> ActionChunk:
        raise SystemExit(3)


def test_a_partner_that_ends_the_program_is_answered_with_a_sentence() -> None:
    with pytest.raises(AgentError, match=rf"idle with {__name__}:Leaving on Simple: SystemExit: 3 \("):
        completion(Trial("idle", f"{__name__}:Leaving", "Simple", 0, 0, 5))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--partner", "dp@all"], "dp@all has no latent to search"),
        (["--partner", "latent@nowhere"], "no checkpoint 'latent@nowhere'"),
        (["--episodes", "0"], "--episodes, --ticks and --worst must be at least 1"),
        (["--workers", "0"], "--workers must be at least 1"),
        (["--seed", "-1"], "--seed is a whole number from 0 on"),
        (["--map", "Nowhere"], "Nowhere"),
    ],
)
def test_what_cannot_be_searched_is_refused(
    options: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["agents", "weakness", "idle", "--partner", MODEL, *SMALL, *options]) == 2
    assert sentence in capsys.readouterr().err
