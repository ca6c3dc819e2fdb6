"""Agents of the tables are trained at a time, after those that they are made of, and with the same numbers as alone."""

import multiprocessing
from collections.abc import Iterator
from pathlib import Path

import pytest

from movingout.agents.checkpoint.checkpoint import folder_name
from movingout.matches.commands import carry_out as carrying
from movingout.matches.commands.carry_out import carry_out
from movingout.matches.errors import MatchError
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.methods import TrainedId, trained_id
from movingout.matches.paper.parallel_training import train_agents
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.steps import paper_steps, seconds_in_all
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import grouped, write_groups
from tests.agents.learning import recorded

pytestmark = pytest.mark.slow

SMOKE = BUDGETS["smoke"]
BASE, BASS, OTHER = (trained_id(name) for name in ("dp-augmented@a", "bass@a", "gru@b"))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    yield tmp_path


def _space(here: Path, workers: int) -> Workspace:
    """With two episodes of two pairs, which is a group each."""
    files = [recorded(here / "theirs", f"{pair}", seed=pair, people=(f"{pair}a", f"{pair}b")) for pair in range(2)]
    space = Workspace(budget=SMOKE, given=(here / "theirs",), workers=workers)
    write_groups(space.listing("c1"), grouped(files, 2))
    return space


def _graphs(folder: Path, agent: TrainedId) -> list[Path]:
    return sorted((folder / "data" / "models" / folder_name(agent.text)).glob("*.onnx"))


def test_they_wait_for_those_that_they_are_made_of_and_learn_the_same_as_alone(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    weights = []
    for workers in (1, 2):
        folder = here / f"{workers}"
        folder.mkdir()
        monkeypatch.chdir(folder)
        took: dict[TrainedId, float] = {}
        train_agents([BASS, BASE, OTHER], _space(folder, workers), took.__setitem__)
        order = list(took)
        assert order.index(BASE) < order.index(BASS) and set(order) == {BASE, BASS, OTHER}
        assert all(seconds > 0 for seconds in took.values())
        weights.append([graph.read_bytes() for agent in (BASE, BASS, OTHER) for graph in _graphs(folder, agent)])
    assert len(weights[0]) > 3 and weights[0] == weights[1]


def test_when_one_fails_it_is_said_why_and_no_other_is_begun(here: Path) -> None:
    space = _space(here, 1)
    lost = trained_id("dp-noise-0.02@a")  # learns from a map of which there is no episode
    with pytest.raises(MatchError, match=r"dp-noise-0\.02@a learns from SingleRotation, and no episode of it is there"):
        train_agents([lost, OTHER], space, lambda agent, seconds: None)
    assert not space.has_agent(OTHER.text)


def test_when_one_fails_the_others_are_ended(here: Path) -> None:
    space = _space(here, 2)
    with pytest.raises(MatchError, match="no episode of it is there"):
        train_agents([OTHER, trained_id("dp-noise-0.02@a")], space, lambda agent, seconds: None)
    assert not space.has_agent(OTHER.text) and not multiprocessing.active_children()


def test_a_process_that_is_killed_is_told_in_a_sentence(here: Path) -> None:
    def kill(agent: TrainedId, seconds: float) -> None:
        for process in multiprocessing.active_children():
            process.kill()

    space = _space(here, 1)
    with pytest.raises(MatchError, match=r"a training was killed, .* with fewer --workers"):
        train_agents([BASE, OTHER], space, kill)
    assert space.has_agent(BASE.text) and not space.has_agent(OTHER.text)


def test_the_command_says_whom_it_trains_and_notes_the_time_of_each(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(carrying, "SHORT_S", 0.0)
    space = _space(here, 2)
    steps = [step for step in paper_steps([ENTRIES["tab:cross_group_eval"]], space) if step.trains in (BASE, BASS)]
    carry_out(steps, space, "")
    said = capsys.readouterr().err
    assert "step 1/2 and on: train 2 agents, 2 at a time" in said and f"is in {here / 'data' / 'logs'}" in said
    assert "step 1/2: dp-augmented@a is trained\nstep 2/2: bass@a is trained\n" in said
    assert all(space.times()[step.about] > 0 for step in steps)
    carry_out(steps, space, "")
    assert capsys.readouterr().err == "", "what is done is not done again"


def test_trainings_at_a_time_take_no_less_than_one_that_waits_for_another() -> None:
    def estimated(workers: int) -> float:
        space = Workspace(budget=BUDGETS["small"], workers=workers)
        trainings = [step for step in paper_steps([ENTRIES["tab:cross_group_eval"]], space) if step.trains]
        return seconds_in_all(trainings, space)

    assert estimated(1) == pytest.approx(2 * estimated(2))
    assert estimated(1) / 4 < estimated(100) < estimated(2), "BASS waits for the policy that proposes its candidates"


def test_short_trainings_are_not_worth_processes_of_their_own(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    space = _space(here, 2)
    steps = [step for step in paper_steps([ENTRIES["tab:cross_group_eval"]], space) if step.trains in (BASE, BASS)]
    carry_out(steps, space, "")
    said = capsys.readouterr().err
    assert "step 1/2: train dp-augmented@a" in said and "at a time" not in said
