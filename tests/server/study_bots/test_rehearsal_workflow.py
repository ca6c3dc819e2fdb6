"""The commands of an experimenter in the order of docs/study.md: check, simulate, report, export, forget."""

import csv
import json
from pathlib import Path

import pytest

from movingout.recordings import Event, finalise
from movingout.recordings.storage.index import list_recordings
from movingout.server.cli import main
from movingout.server.study_bots.commands import rehearsal_command
from movingout.server.study_bots.data_check import StoredData, agent_faults, read_stored
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import read_study
from tests.recordings.support import begin, play
from tests.server.study_bots.support import agents_text


def _traces(folder: Path, *words: str) -> list[str]:
    """Files below a folder in which one of the words stands."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    return [path.name for path in files if any(word.encode() in path.read_bytes() for word in words)]


@pytest.mark.slow
def test_a_rehearsal_is_reported_exported_and_forgotten_and_always_says_that_it_is_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("study.yaml").write_text(agents_text(ticks=40), encoding="utf-8")
    at = ["study.yaml", "--data", "rehearsal"]
    assert main(["study", "check", "study.yaml"]) == 0
    capsys.readouterr()
    simulate = ["study", "simulate", *at, "--participants", "2", "--speed", "max"]
    assert main([*simulate, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["participants"], told["outcomes"], told["codes"], told["lost"]) == (2, {"done": 2}, 2, [])
    assert sum(told["rounds"].values()) == 2 * 4
    assert told["answers"] == told["clicks"] == 2 * (7 + 2 * 10 + 6)
    assert main(simulate) == 2, "a folder is never rehearsed in twice"
    assert "exists already" in capsys.readouterr().err
    assert main(["study", "report", *at]) == 0
    assert "The participants were simulated" in Path("short-agents-simulated-report/report.html").read_text("utf-8")
    assert main(["study", "export", *at]) == 0
    export = Path("short-agents-simulated-export")
    assert json.loads((export / "about.json").read_text())["simulated"] is True
    with (export / "participants.csv").open(encoding="utf-8", newline="") as stream:
        pids = [row["pid"] for row in csv.DictReader(stream)]
    assert len(pids) == 2
    found, _ = list_recordings(Path("rehearsal/recordings"))
    assert {one.study["simulated"] for one in found} == {"yes"}
    forget_leaves_no_trace(pids)


def forget_leaves_no_trace(pids: list[str]) -> None:
    data = Path("rehearsal")
    folder = StudyFolder(read_study(Path("study.yaml")), data)
    stored = read_stored(folder)
    names = {pid: name for name, pid in stored.pids.items()}
    gone, stays = pids
    code = stored.participants[gone]["code"]
    assert len(_traces(data, gone)) > 4, "the test looks for the right word"
    assert main(["study", "forget", "study.yaml", gone, "--data", "rehearsal"]) == 0
    assert _traces(data, gone, names[gone], code) == []
    assert len(_traces(data, stays)) > 4
    assert list(read_stored(folder).participants) == [stays]


def test_a_rehearsal_in_which_an_agent_had_a_fault_says_so_and_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("round-0", "round-1", "of-another-study"):
        writer, played = begin(tmp_path / "recordings", episode_id=name)
        writer.event(Event(1, "agent_error", 0, detail="own needs 130 ms for a decision"))
        play(writer, played, 2)
        finalise(writer.close("time"))
    file = tmp_path / "study.yaml"
    file.write_text(agents_text(ticks=40), encoding="utf-8")
    rounds = [{"episode": f"round-{number}", "outcome": "time"} for number in range(2)]
    stored = StoredData({}, {}, rounds, [])
    faults = agent_faults(StudyFolder(read_study(file), tmp_path), stored)
    assert faults == ["in 2 rounds: own needs 130 ms for a decision"]
    assert agent_faults(StudyFolder(read_study(file), tmp_path / "none"), stored) == []
    result = rehearsal_command.RehearsalResult([], data=tmp_path, faults=faults)
    monkeypatch.setattr(rehearsal_command, "rehearse", lambda *_: result)
    assert main(["study", "simulate", str(file)]) == 1
    assert "an agent had a fault in 2 rounds: own needs 130 ms" in capsys.readouterr().out
    assert main(["study", "simulate", str(file), "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["faults"] == faults


def test_a_server_that_runs_already_decides_itself_about_slow_agents(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(rehearsal_command, "_watched", lambda *_: [])
    file = tmp_path / "study.yaml"
    file.write_text(agents_text(ticks=40), encoding="utf-8")
    at = ["study", "simulate", str(file), "--url", "http://127.0.0.1:9"]
    assert main(at) == 0
    assert main([*at, "--slow-agents"]) == 2
    assert "study serve --rehearse 1 --slow-agents" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("where", "said"),
    [
        (["--data", "half"], "in half; another rehearsal needs a new folder"),
        (["--url", "http://127.0.0.1:9"], "on the server at http://127.0.0.1:9"),
    ],
)
def test_a_rehearsal_that_is_interrupted_says_what_stays(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    where: list[str],
    said: str,
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    Path("study.yaml").write_text(agents_text(ticks=40), encoding="utf-8")
    monkeypatch.setattr(rehearsal_command, "rehearse", interrupted)
    monkeypatch.setattr(rehearsal_command, "_watched", interrupted)
    assert main(["study", "simulate", "study.yaml", "--participants", "2", *where]) == 130
    assert f"movingout: stopped; what was played until then stays {said}" in capsys.readouterr().err
