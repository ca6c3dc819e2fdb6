"""`movingout train self-play`: from maps to an agent in a seat, and to a family of partners."""

import json
from pathlib import Path

import pytest

pytest.importorskip("torchrl")

from movingout.agents.catalogue import load_agent, trained_cards
from movingout.agents.checkpoint.checkpoint import SHIPPED, find_checkpoint
from movingout.agents.conformance import check_agent
from movingout.agents.errors import AgentError, CheckpointError
from movingout.agents.kinds.self_play import AGES
from movingout.agents.live_options import check_live_agent
from movingout.agents.partners.families import MEMBERS, SELF_PLAY_SEEDS, families
from movingout.agents.partners.options.trained import TrainedScores
from movingout.server.cli import main
from tests.agents.trained import load_checkpoint

TINY = ["--episodes", "4", "--round-episodes", "2", "--young", "2", "--ticks", "30", "--width", "8", "--passes", "1"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_it_writes_an_agent_that_plays_old_and_young(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["train", "self-play", "--map", "Simple,HandOff", "--id", "self-play@tiny", *TINY]
    assert main([*command, "--json"]) == 0
    shown = capsys.readouterr()
    trained = json.loads(shown.out)
    assert (trained["episodes"], trained["updates"]) == (4, 2) and trained["windows"] > 8
    assert "2 of 4 episodes, delivered" in shown.err and "4 of 4 episodes, delivered" in shown.err
    checkpoint = find_checkpoint("self-play@tiny", here / "data" / "models")
    assert checkpoint.card.maps == ("HandOff", "Simple") and {entry.name for entry in checkpoint.card.files} == set(
        AGES.values()
    )
    assert checkpoint.read("policy.onnx") != checkpoint.read("young.onnx")
    check_agent(lambda: load_agent("self-play@tiny:seed=2,age=young,temperature=0.5"), maps=["HandOff"], ticks=8)
    (card,) = [card for card in trained_cards() if card.id == "self-play@tiny"]
    assert not card.offered
    assert main(command) == 0 and "of 4 episodes" not in capsys.readouterr().err, "nothing is left to do"
    assert main([*command, "--discount", "0.5"]) == 2
    assert "choose another --id, or continue with --go-on" in capsys.readouterr().err
    assert main([*command, "--round-episodes", "1", "--go-on"]) == 2, "the count of its episodes would be another"
    assert (
        "round-episodes 2, not 1; to continue it, add --round-episodes 2, or train that under"
        in capsys.readouterr().err
    )
    assert main([*command, "--map", "FourCorners", "--go-on", "--episodes", "6"]) == 0
    later = find_checkpoint("self-play@tiny", here / "data" / "models").card
    assert later.maps == ("FourCorners", "HandOff", "Simple")
    assert "on 1 map, and on others before." in later.description
    assert set(checkpoint.card.training.items or ()) < set(later.training.items or ())
    for options, sentence in {
        "age=middle": "unknown age 'middle'; known: old, young",
        "temperature=-1": "temperature is a number from 0",
        "seed=x": "seed is a whole number",
        "noise=1": "options: seed, age, temperature",
    }.items():
        for load in (load_agent, check_live_agent):
            with pytest.raises(AgentError, match=sentence):
                load(f"self-play@tiny:{options}")
    with pytest.raises(AgentError, match="temperature"):
        load_checkpoint(checkpoint, temperature=True)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--episodes", "0"], "--episodes 0: input should be greater than or equal to 1"),
        (["--episodes", "10", "--young", "200"], "--young 200: only 12 episodes are played; give at most as many"),
        (["--own", "2"], "--own 2"),
        (["--map", "HandOf"], "did you mean HandOff"),
        (["data/demos"], "self-play learns from its own play, on maps that --map names; leave out the recordings"),
        (["--id", "mappo@x"], "take --id self-play@x"),
    ],
)
def test_bad_options_are_refused_with_a_sentence(
    words: list[str], sentence: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["train", "self-play", *words]) == 2
    assert sentence in capsys.readouterr().err


def test_a_network_of_another_shape_is_refused() -> None:
    shipped = find_checkpoint("latent@families", SHIPPED)
    with pytest.raises(CheckpointError, match="it is of another version, so train it again"):
        TrainedScores(shipped.read("policy.onnx"))


def test_the_family_has_every_training_at_both_ages() -> None:
    members = families()["self-play"].members
    assert len(members) == MEMBERS == len({one.agent_id for one in members})
    named = {(one.agent_id.partition(":")[0], one.agent_id.partition("age=")[2].partition(",")[0]) for one in members}
    assert len(named) == 2 * SELF_PLAY_SEEDS


@pytest.mark.parametrize("number", range(0, MEMBERS, 5))
def test_members_of_the_family_keep_the_contract(number: int) -> None:
    agent_id = families()["self-play"].members[number].agent_id
    check_agent(lambda: load_agent(agent_id), maps=["HandOff"], ticks=20)
