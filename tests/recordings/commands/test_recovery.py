"""`movingout recordings recover` as a user types it."""

import json
from pathlib import Path

import pytest

from movingout.recordings import RecordingError, finalise
from movingout.recordings.commands import recovery
from movingout.recordings.storage.finished import Recovery
from movingout.server.cli import main
from tests.recordings.support import begin, play, record


@pytest.mark.parametrize(
    ("name", "reason"),
    [("foreign.mcap", "is not an MCAP file"), ("notes.txt", "is neither a recording (*.mcap) nor a journal")],
)
def test_recover_leaves_alone_what_is_not_ours(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, reason: str
) -> None:
    path = tmp_path / name
    path.write_bytes(b"not ours")
    assert main(["recordings", "recover", str(path)]) == 2
    assert reason in capsys.readouterr().err
    assert [entry.name for entry in tmp_path.iterdir()] == [name] and path.read_bytes() == b"not ours"


def test_recover_saves_a_torn_recording_and_leaves_a_whole_one_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = finalise(record(tmp_path, ticks=60)[0])
    whole = path.read_bytes()
    assert main(["recordings", "recover", str(path)]) == 0
    assert capsys.readouterr().out == "episode.mcap: 60 ticks, whole; left as it is\n" and path.read_bytes() == whole
    path.write_bytes(whole[: len(whole) // 2])
    assert main(["recordings", "verify", str(path)]) == 2
    assert "save what is whole: movingout recordings recover FILE" in capsys.readouterr().out
    assert main(["recordings", "recover", str(path)]) == 0
    assert "saved from a torn or damaged file up to tick" in capsys.readouterr().out
    assert main(["recordings", "verify", str(path)]) == 0


def test_recover_names_what_is_below_a_folder_and_what_is_damaged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """There was nothing to recover, it said."""
    left, _ = record(tmp_path / "day 1", ticks=6, episode_id="left")
    torn = finalise(record(tmp_path / "day 2", ticks=6, episode_id="torn")[0])
    torn.write_bytes(torn.read_bytes()[:-100])
    (tmp_path / "other.mcap").write_bytes(b"somebody else's")
    assert main(["recordings", "recover", str(tmp_path)]) == 2
    said = capsys.readouterr()
    assert said.out == "left.mcap.journal -> left.mcap: 6 ticks, whole\n" and not left.exists()
    command = f"movingout recordings recover '{torn}'"
    assert said.err == f"movingout: torn.mcap: incomplete or damaged; save what is whole: {command}\n"
    assert main(["recordings", "recover", str(torn)]) == 0
    assert main(["recordings", "recover", str(tmp_path)]) == 0


def test_recover_tells_what_it_did_though_a_folder_below_cannot_be_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def unreadable(folder: Path) -> list[Recovery]:
        raise RecordingError("cannot list lost+found: Permission denied")

    monkeypatch.setattr(recovery, "damaged_below", unreadable)
    record(tmp_path, ticks=6, episode_id="left")
    assert main(["recordings", "recover", str(tmp_path)]) == 2
    said = capsys.readouterr()
    assert said.out == "left.mcap.journal -> left.mcap: 6 ticks, whole\n" and "cannot list lost+found" in said.err


def test_recover_finishes_what_was_left(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    writer, played = begin(tmp_path / "recordings")
    play(writer, played, 4)
    writer.abandon()
    assert main(["recordings", "recover", "--data", str(tmp_path), "--json"]) == 0
    (entry,) = json.loads(capsys.readouterr().out)["journals"]
    assert (entry["ticks"], entry["note"]) == (4, "interrupted after tick 4")
    assert Path(entry["recording"]).name == "episode.mcap"
    assert main(["recordings", "recover", "--data", str(tmp_path)]) == 0
    assert capsys.readouterr().out == "nothing to recover\n"


def test_recover_goes_on_after_a_journal_that_it_cannot_finish(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first one ended the command, and those after it stayed journals."""
    folder = tmp_path / "recordings"
    for name in ("a", "b", "c"):
        record(folder, ticks=2, episode_id=name)
    (folder / "a.mcap").write_bytes(b"of a failing disk")
    (folder / "b.mcap.journal").unlink()
    (folder / "b.mcap.journal").mkdir()
    assert main(["recordings", "recover", "--data", str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert out == "c.mcap.journal -> c.mcap: 2 ticks, whole\n"
    assert "a.mcap.journal: a.mcap is damaged, move it away and recover again (a.mcap is not an MCAP file)" in err
    assert "b.mcap.journal: cannot open" in err
    (folder / "a.mcap").unlink()
    assert main(["recordings", "recover", str(tmp_path / "gone.mcap"), str(folder), "--json"]) == 2
    entries = json.loads(capsys.readouterr().out)["journals"]
    assert [(Path(one["journal"]).name, one["failed"]) for one in entries] == [
        ("gone.mcap", True),
        ("a.mcap.journal", False),
        ("b.mcap.journal", True),
    ]
