"""Rehearsals: simulated participants go through whole studies on real servers, and no data are lost."""

from dataclasses import replace
from pathlib import Path

import pytest

from movingout.server.study_bots.commands.rehearsal_command import RehearsalResult, rehearse
from movingout.server.study_bots.data_check import find_losses, read_stored
from movingout.server.study_bots.simulated_participant import SavedAnswer
from movingout.server.study_bots.simulation_plan import SimulationPlan
from movingout.server.study_bots.study_client import SimulationError
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import read_study
from tests.server.study_bots.support import agents_text, pairs_text


def _file(folder: Path, text: str) -> Path:
    path = folder / "study.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_server_of_a_rehearsal_lets_slow_agents_play_where_the_study_will(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands: list[list[str]] = []

    def start(command: list[str], **_: object) -> None:
        commands.append(command)
        raise SimulationError("no server today")

    monkeypatch.setattr("subprocess.Popen", start)
    file = _file(tmp_path, agents_text())
    for plan in (SimulationPlan(1), SimulationPlan(1, slow_agents=True)):
        with pytest.raises(SimulationError, match="today"):
            rehearse(file, plan, tmp_path / "data")
    assert ["--slow-agents" in command for command in commands] == [False, True]


def _chaos(folder: Path, text: str, plan: SimulationPlan, kills: int) -> RehearsalResult:
    done = rehearse(_file(folder, text), replace(plan, chaos=True, scripted=False), folder / "data", kills)
    assert done.stored is not None
    assert done.lost == []
    assert all(len(log.codes) == 1 for log in done.logs)
    assert len(done.stored.participants) == plan.participants
    return done


@pytest.mark.slow
def test_pairs_find_each_other_and_nothing_is_lost_when_the_server_is_killed(tmp_path: Path) -> None:
    done = _chaos(tmp_path, pairs_text(wait_s=10), SimulationPlan(2, speed=20, seed=3), kills=1)
    assert done.stored is not None
    units = {row["unit"] for row in done.stored.participants.values()}
    assert units == {1}


@pytest.mark.slow
def test_what_is_lost_is_found_and_said(tmp_path: Path) -> None:
    file = _file(tmp_path, agents_text(ticks=10))
    done = rehearse(file, SimulationPlan(1, speed=20, scripted=False), tmp_path / "data")
    folder = StudyFolder(read_study(file), tmp_path / "data")
    (log,), stored = done.logs, read_stored(folder)
    assert find_losses(folder, stored, [log]) == []
    click, recording = log.saved_answers[0], next((tmp_path / "data" / "recordings").glob("*.mcap"))
    log.saved_answers.append(SavedAnswer(click.step, click.item, 99, ""))
    log.codes.add("ANOTHER")
    log.rounds.add("play/9/Simple-1")
    recording.unlink()
    found = "\n".join(find_losses(folder, stored, [log]))
    for words in ("the answer", "shown the codes", "the round play/9/Simple-1 is missing", "its recording is missing"):
        assert words in found
    assert len(found.splitlines()) == 4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "people"), [(pairs_text(wait_s=15), 32), (agents_text(), 16)], ids=["pairs", "agents"]
)
def test_participants_with_faults_and_three_kills_lose_nothing(tmp_path: Path, text: str, people: int) -> None:
    """Every finished round has one recording and one row, every answer is saved, everybody has one code."""
    _chaos(tmp_path, text, SimulationPlan(people, speed=10, seed=11, at_once=32), kills=3)
