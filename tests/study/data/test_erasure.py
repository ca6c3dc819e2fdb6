"""Recordings are deleted while a server finishes others: files appear, are renamed and go between two looks."""

import os
from pathlib import Path

import pytest

from movingout.recordings import finalise
from movingout.recordings.episode import SeatInfo
from movingout.recordings.storage.listing import Summary
from movingout.study.data import erasure
from movingout.study.data.erasure import (
    due_now,
    erase,
    is_being_recorded,
    named_in_recordings,
    purge,
    remove_recordings,
)
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from movingout.study.errors import StudyError
from tests.recordings.support import record
from tests.study.support import TEXT, agree, open_identities, open_store, study

PID = "P7QRS2"


def journal(folder: Path, episode: str, pid: str = PID) -> Path:
    return record(folder, ticks=3, episode_id=episode, seats=(SeatInfo("human", pid), SeatInfo("agent", "idle")))[0]


def finished_meanwhile(monkeypatch: pytest.MonkeyPatch, part: Path, whole: Path) -> None:
    """A part that somebody renames after the first look into the folder, and before it is read."""
    really = erasure._listed

    def listed(folder: Path) -> tuple[list[Summary], set[Path]]:
        found = really(folder)
        if part.exists():
            part.rename(whole)
        return found

    monkeypatch.setattr(erasure, "_listed", listed)


def test_a_part_that_becomes_a_recording_meanwhile_is_deleted_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = finalise(journal(tmp_path, "mine"))
    part = whole.rename(whole.with_name(whole.name + ".tmp"))
    finished_meanwhile(monkeypatch, part, whole)
    assert remove_recordings(tmp_path, PID, {"mine"}) == 1
    assert not any(tmp_path.glob("mine*"))


def test_somebody_elses_part_that_is_finished_meanwhile_stops_no_deletion(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    finalise(journal(tmp_path, "mine"))
    whole = finalise(journal(tmp_path, "other", "P3XYZ9"))
    part = whole.rename(whole.with_name(whole.name + ".tmp"))
    finished_meanwhile(monkeypatch, part, whole)
    assert remove_recordings(tmp_path, PID, set()) == 1
    assert [path.name for path in tmp_path.glob("*.mcap*")] == ["other.mcap"]


def test_a_round_is_being_recorded_until_its_file_is_finished(tmp_path: Path) -> None:
    mine = journal(tmp_path, "mine")
    assert is_being_recorded(tmp_path, PID, set()) and is_being_recorded(tmp_path, "PNOBODY", {"mine"})
    assert not is_being_recorded(tmp_path, "PNOBODY", {"another"})
    finalise(mine)
    assert not is_being_recorded(tmp_path, PID, {"mine"})


def test_who_is_named_in_recordings_is_found_also_in_damaged_ones(tmp_path: Path) -> None:
    finalise(journal(tmp_path, "mine"))
    whole = finalise(journal(tmp_path, "broken", "P3XYZ9"))
    whole.write_bytes(whole.read_bytes()[:-60])
    assert named_in_recordings(tmp_path, [PID, "P3XYZ9", "PNOBODY"]) == {PID, "P3XYZ9"}
    assert named_in_recordings(tmp_path / "nowhere", [PID]) == set()


def test_a_file_whose_name_is_not_utf8_stops_no_deletion_and_is_deleted_if_it_names_them(tmp_path: Path) -> None:
    odd = tmp_path / os.fsdecode(b"caf\xe9.mcap")
    finalise(journal(tmp_path, "other", "P3XYZ9")).rename(odd)
    finalise(journal(tmp_path, "mine"))
    assert remove_recordings(tmp_path, PID, {"mine"}) == 1
    assert [path for path in tmp_path.iterdir() if path.suffix == ".mcap"] == [odd]
    assert remove_recordings(tmp_path, "P3XYZ9", set()) == 1 and not odd.exists()


@pytest.mark.parametrize("left", ["nothing", "an empty file"])
def test_identities_that_were_deleted_or_lost_are_not_made_anew(tmp_path: Path, left: str) -> None:
    """The study would be served again, and whoever comes back would begin once more."""
    folder = StudyFolder(study(), tmp_path)
    store = open_store(folder.own)
    agree(store, [PID])
    identities = folder.own / "identity.sqlite"
    if left != "nothing":
        identities.touch()
    assert due_now(folder, store).identities == purge(folder, store).identities == ()
    assert erase(folder, store, PID).identity is False
    assert not folder.has_identities and identities.exists() == (left != "nothing")


def test_a_code_that_several_may_have_finds_nobody_and_the_id_on_the_platform_does(tmp_path: Path) -> None:
    folder = StudyFolder(parse_study(TEXT.replace("codes: unique", "codes: {withdrew: STOP1}")), tmp_path)
    store, identities = open_store(folder.own), open_identities(folder.own)
    pid, _ = identities.pid("prolific", "5f3c")
    agree(store, [pid])
    store.finish(pid, "withdrew", "STOP1")
    with pytest.raises(StudyError, match="'STOP1' is the code of all who end alike"):
        erase(folder, store, "STOP1")
    assert erase(folder, store, "5f3c").pid == pid and identities.pids("5f3c") == []
