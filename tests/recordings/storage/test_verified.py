"""Recordings are verified once, and again when they have changed."""

from pathlib import Path

import pytest

from movingout.recordings import finalise, verification
from movingout.recordings.commands import verify
from movingout.recordings.verification import Verification
from movingout.server.cli import main
from tests.recordings.support import record


def test_every_night_before_the_first_round_is_no_error_and_a_folder_that_lost_all_is_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["recordings", "verify", str(tmp_path), "--new", "--workers", "1"]
    assert main(command) == 0 and capsys.readouterr().out == "nothing new to verify\n"
    assert main(["recordings", "verify", str(tmp_path)]) == 2
    assert main(["recordings", "verify", str(tmp_path / "moved-away"), "--new"]) == 2
    recording = finalise(record(tmp_path, ticks=12, episode_id="first")[0])
    assert main(command) == 0
    recording.unlink()
    assert main(command) == 2


def test_new_recordings_are_verified_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["recordings", "verify", str(tmp_path), "--new", "--workers", "1"]
    first = finalise(record(tmp_path, ticks=12, episode_id="first")[0])
    assert main(command) == 0 and first.name in capsys.readouterr().out
    assert main(command) == 0 and capsys.readouterr().out == "nothing new to verify\n"
    second = finalise(record(tmp_path, ticks=13, episode_id="second")[0])
    assert main(command) == 0
    said = capsys.readouterr().out
    assert second.name in said and first.name not in said
    first.write_bytes(first.read_bytes()[:-100])
    assert main(command) == 2, "what is damaged is named each time"
    assert main(command) == 2
    (tmp_path / ".verified.json").write_text("[[[")
    assert main([*command, "--json"]) == 2


def test_what_was_verified_before_ctrl_c_is_not_verified_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a", "b"):
        finalise(record(tmp_path, ticks=2, episode_id=name)[0])
    command = ["recordings", "verify", str(tmp_path), "--new", "--workers", "1"]

    def interrupted(path: Path) -> Verification:
        if path.name == "b.mcap":
            raise KeyboardInterrupt
        return verification.verify(path)

    with monkeypatch.context() as patched:
        patched.setattr(verify, "verify", interrupted)
        assert main(command) == 130
    capsys.readouterr()
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "b.mcap" in said and "a.mcap" not in said


def test_the_verdict_stands_where_it_cannot_be_noted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(paths: list[Path]) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(verify, "note_verified", full)
    finalise(record(tmp_path, ticks=2)[0])
    assert main(["recordings", "verify", str(tmp_path), "--new", "--workers", "1"]) == 0
    assert "cannot note what was verified: No space left on device" in capsys.readouterr().err
