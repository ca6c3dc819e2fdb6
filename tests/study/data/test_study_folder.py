"""The folder of a study's data."""

import fcntl
from pathlib import Path

import pytest

from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from movingout.study.errors import StudyError, StudyFileError
from tests.study.support import TEXT, open_store, study


def test_one_process_at_a_time_has_a_study_and_the_next_may_when_it_has_ended(tmp_path: Path) -> None:
    folder = StudyFolder(study(), tmp_path)
    with folder.exclusive(), pytest.raises(StudyError, match="is being served from"), folder.exclusive():
        pass
    with folder.exclusive():
        pass


def test_a_server_of_an_earlier_version_keeps_the_study(tmp_path: Path) -> None:
    folder = StudyFolder(study(), tmp_path)
    folder.own.mkdir(parents=True)
    with (folder.own / "serving.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        with pytest.raises(StudyError, match="is being served from"), folder.exclusive():
            pass


def test_data_recorded_with_a_study_that_would_be_refused_today_can_be_read(tmp_path: Path) -> None:
    box = "    - {id: copied, required: false, text: Yes.}\n"
    text = TEXT.replace("  boxes:\n", f"  boxes:\n{box}{box}", 1)
    with pytest.raises(StudyFileError, match="'copied' is taken"):
        parse_study(text)
    begun = StudyFolder(study(), tmp_path).as_frozen(open_store(tmp_path, text=text), tmp_path).study
    assert [one.id for one in begun.consent.boxes][:2] == ["copied", "copied"]
