"""Recordings of matches take nothing away: neither finished ones nor those that another process writes."""

import warnings
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.matches import play, run_grid
from movingout.matches.execution import recorder
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.execution.recorder import MatchRecorder, superseded
from movingout.matches.match import Match
from movingout.matches.results.results_folder import Shard, read_results
from movingout.recordings import read_episode
from movingout.recordings.errors import BusyError, RecordingError
from movingout.recordings.storage.finished import recover
from movingout.server.cli import main
from movingout.world import World
from tests.matches.support import HERE, small_grid

MATCH = Match("HandOff", "idle", "idle", 0, ticks=3)
GRID = "name: two\nagents: [idle]\nmaps: [HandOff]\nseeds: 2\nticks: 3\n"


def _recorder(folder: Path) -> MatchRecorder:
    return MatchRecorder(folder, MATCH, World(MATCH.world_map(), record_sub_poses=False).state())


def _names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_match_that_is_recorded_again_leaves_the_recording_that_was_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["match", "--red", "idle", "--blue", "idle", "--map", "HandOff", "--ticks", "3", "--workers", "1"]
    command += ["--record", str(tmp_path)]
    assert main(command) == 0
    assert "recorded" not in capsys.readouterr().err
    [first] = tmp_path.iterdir()
    before = first.read_bytes()
    assert main(command) == 0
    assert "1 match was recorded in this folder before" in capsys.readouterr().err
    with pytest.warns(UserWarning, match=r"the new recordings have a number behind their names \(-3\)"):
        play("idle", "idle", ticks=3, workers=1, record=tmp_path)
    stem = first.name.removesuffix(".mcap")
    assert _names(tmp_path) == sorted([first.name, f"{stem}-2.mcap", f"{stem}-3.mcap"])
    assert first.read_bytes() == before
    assert read_episode(tmp_path / f"{stem}-2.mcap").header.episode_id == f"{stem}-2"


def test_two_processes_do_not_record_the_same_match_into_one_folder(tmp_path: Path) -> None:
    running = _recorder(tmp_path)
    with pytest.raises(BusyError, match=r"another process records this match here \(.*\.mcap\.journal\); wait until"):
        _recorder(tmp_path)
    assert running.close("time", 0).is_file()


def test_the_journal_of_a_killed_run_goes_and_a_whole_one_stays(tmp_path: Path) -> None:
    killed = _recorder(tmp_path)
    killed._writer.abandon()
    ended = _recorder(tmp_path)
    ended._writer.close("time")
    [result] = Lockstep(record=tmp_path).play([MATCH])
    assert Path(result.recording).name == f"HandOff-{MATCH.id}-2.mcap"
    [recovered] = recover(tmp_path)
    assert recovered.note == "whole"
    assert _names(tmp_path) == [f"HandOff-{MATCH.id}-2.mcap", f"HandOff-{MATCH.id}.mcap"]


def test_a_match_that_was_played_but_not_finalised_keeps_its_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk took the whole match away."""

    def full(journal: Path) -> Path:
        raise RecordingError("cannot write there: no space left on device")

    monkeypatch.setattr(recorder, "finalise", full)
    with pytest.raises(RecordingError, match="no space"):
        list(Lockstep(record=tmp_path).play([MATCH, replace(MATCH, seed=1, ticks=9)]))
    assert _names(tmp_path) == [f"HandOff-{MATCH.id}.mcap.journal"]
    assert [(one.note, one.ticks) for one in recover(tmp_path)] == [("whole", 3)]


def test_a_grid_replaces_what_was_recorded_of_matches_without_a_result(tmp_path: Path) -> None:
    grid = small_grid(agents=[f"{HERE}:Wanderer"], maps=["HandOff"], seeds=2, ticks=3)
    run = run_grid(grid, tmp_path, workers=1, record=True)
    kept, lost = run.results.values()
    (tmp_path / "results-0-of-1.jsonl").unlink()
    with Shard(tmp_path) as shard:
        shard.append([kept])
    before = (tmp_path / kept.recording).read_bytes()
    again = run_grid(grid, tmp_path, workers=1, record=True).results
    assert _names(tmp_path / "recordings") == sorted(Path(one.recording).name for one in again.values())
    assert (tmp_path / kept.recording).read_bytes() == before
    assert again[lost.match].recording != lost.recording


def test_a_match_that_fails_again_keeps_the_recording_that_its_results_name(tmp_path: Path) -> None:
    grid = small_grid(agents=[f"{HERE}:Stumbling"], maps=["HandOff"], seeds=2, ticks=12)
    run_grid(grid, tmp_path, workers=1, record=True, shard=(1, 2))
    run_grid(grid, tmp_path, workers=1, record=True)
    whole, failed = read_results(tmp_path).values()
    assert (whole.ending == "failed", failed.ending == "failed") in ((False, True), (True, False))
    assert all((tmp_path / one.recording).is_file() for one in (whole, failed))


def test_where_a_worker_died_after_it_had_recorded_a_match_one_recording_stays(tmp_path: Path) -> None:
    later = tmp_path / "HandOff-0123456789abcdef-3.mcap"
    names = [
        f"HandOff-0123456789abcdef{number}{suffix}" for number in ("", "-2") for suffix in (".mcap", ".mcap.journal")
    ]
    assert [path.name for path in superseded(later)] == names
    assert superseded(tmp_path / "HandOff-0123456789abcdef.mcap") == []


def test_a_grid_says_which_matches_were_played_without_a_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "grid.yaml").write_text(GRID)
    command = ["match", "grid", str(tmp_path / "grid.yaml"), "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main([*command, "--shard", "0/2"]) == 0
    assert main([*command, "--shard", "1/2", "--record"]) == 0
    assert "recording" not in capsys.readouterr().err
    with warnings.catch_warnings(action="error"):
        assert main([*command, "--record"]) == 0
    sentence = "movingout: 1 match was played before without a recording; use another --out to record it\n"
    assert capsys.readouterr().err == sentence
    assert main(command) == 0
    assert capsys.readouterr().err == ""
