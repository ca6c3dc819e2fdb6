"""A kind of agent is one record: commands, catalogue and workers need to know nothing else about it."""

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.base import Agent
from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.catalogue import damaged_cards, load_agent, trained_cards
from movingout.agents.checkpoint.checkpoint import CARD, Checkpoint, write_checkpoint
from movingout.agents.errors import AgentError
from movingout.agents.kinds.kind import AgentKind, Trained
from movingout.agents.kinds.registry import KINDS
from movingout.agents.training.optimisation import Optimisation, documented
from movingout.agents.training.run import TrainingRun
from movingout.server.cli import main
from tests.agents.learning import recorded


@dataclass(frozen=True, kw_only=True)
class MeanConfig(Optimisation):
    """Of an agent that repeats the mean of what it has seen."""

    scale: float = documented(1.0, "by how much the mean is multiplied")


class MeanAgent(IdleAgent):
    """Would drive with the mean distance."""

    def __init__(self, distance: float, faster: float) -> None:
        self.distance = distance * faster


def _train(run: TrainingRun[MeanConfig]) -> Trained:
    data = run.read_data()
    before = run.begin_on(data)
    assert not before
    distance = float(np.mean([trajectory.actions[..., 0].mean() for trajectory in data.episodes])) * run.config.scale
    training = run.training(data, data.people, len(data.episodes), updates=1)
    card = {
        "schema_version": 1, "id": run.agent_id, "name": run.name, "description": "The mean.", "kind": "mean",
        "maps": ["HandOff"], "training": training.model_dump(),
    }  # fmt: skip
    return Trained(write_checkpoint(run.model_folder, card, {"mean.json": json.dumps(distance).encode()}), training)


def _load(checkpoint: Checkpoint, faster: float = 1.0) -> Agent:
    return MeanAgent(json.loads(checkpoint.read("mean.json")), faster)


def _no_options(parser: argparse.ArgumentParser) -> None:
    pass


MEAN = AgentKind(
    name="mean",
    summary="the mean of what was done",
    presets={"fast": MeanConfig(), "paper": MeanConfig()},
    add_options=_no_options,
    option_names=(),
    train=_train,
    load=_load,
)


@pytest.fixture
def trained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with `data/models`, in which an agent of a new kind has been trained by the usual command."""
    monkeypatch.setitem(KINDS, "mean", MEAN)
    monkeypatch.chdir(tmp_path)
    recorded(tmp_path / "recordings", "e0", ticks=10)
    assert main(["train", "mean", "recordings", "--id", "mean@mine", "--scale", "2"]) == 0
    return tmp_path


def test_a_new_kind_is_trained_listed_and_loaded_by_its_record_alone(trained: Path) -> None:
    (card,) = [card for card in trained_cards() if card.id == "mean@mine"]
    assert (card.kind, card.policy) == ("mean", "mean")
    agent, faster = load_agent("mean@mine"), load_agent("mean@mine:faster=3")
    assert isinstance(agent, MeanAgent) and isinstance(faster, MeanAgent)
    assert 0.6 < agent.distance < 2.0 and faster.distance == 3 * agent.distance
    assert json.loads((trained / "data" / "runs" / "mean-mine" / "config.json").read_text())["scale"] == 2.0
    with pytest.raises(AgentError, match=r"options: faster$"):
        load_agent("mean@mine:slower=3")


def test_an_agent_of_an_unknown_kind_is_left_out_and_named(trained: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(KINDS, "mean")
    assert (trained / "data" / "models" / "mean-mine" / CARD).exists()
    assert "mean@mine" not in {card.id for card in trained_cards()}
    sentence = f"mean@mine is of the unknown kind 'mean'; known: {', '.join(KINDS)}"
    assert damaged_cards() == [sentence]
    with pytest.raises(AgentError, match=sentence):
        load_agent("mean@mine")
