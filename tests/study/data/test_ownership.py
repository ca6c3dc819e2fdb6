"""What root's commands make in a data folder belongs to whom it belongs, so that the server can go on with it."""

import os
from pathlib import Path

from movingout.recordings import finalise
from movingout.recordings.annotation.finding import VERDICTS
from movingout.recordings.annotation.search import SEARCH_NAME, search_failures
from movingout.recordings.annotation.verdicts import LOCK_NAME, VERDICTS_NAME, add_verdict, new_line
from movingout.recordings.report.failures import CASES
from movingout.recordings.storage.index import INDEX_NAME, list_recordings
from movingout.recordings.storage.s3_bucket import DELETED, UPLOADED_TO, note_uploads
from movingout.study.data.erasure import remove_recordings
from movingout.study.data.study_folder import StudyFolder
from tests.owners import SERVER, only_root, owners
from tests.recordings.support import record
from tests.study.support import study


@only_root
def test_folders_and_the_lock_belong_to_whom_the_data_folder_belongs(tmp_path: Path) -> None:
    os.chown(tmp_path, SERVER, SERVER)
    folder = StudyFolder(study(), tmp_path)
    with folder.exclusive():
        pass
    own = f"studies/{folder.study.id}"
    assert owners(tmp_path) == dict.fromkeys(("studies", own, f"{own}/serving.lock"), SERVER)


@only_root
def test_after_a_deletion_by_root_the_server_can_delete_annotate_and_list(tmp_path: Path) -> None:
    recordings = tmp_path / "recordings"
    for name in ("gone", "kept"):
        finalise(record(recordings, ticks=3, episode_id=name)[0])
        add_verdict(recordings, new_line(f"{name}:{CASES[0]}:0:1", VERDICTS[0], "Ann"))
    for path in (tmp_path, recordings, *recordings.iterdir()):
        os.chown(path, SERVER, SERVER)
    remove_recordings(recordings, "nobody", {"gone"})
    list_recordings(recordings)
    search_failures(recordings)
    note_uploads(tmp_path, "s3://bucket/folder")
    made = {
        DELETED,
        UPLOADED_TO,
        f"recordings/{VERDICTS_NAME}",
        f"recordings/{LOCK_NAME}",
        f"recordings/{INDEX_NAME}",
        f"recordings/{SEARCH_NAME}",
    }
    assert owners(tmp_path) == dict.fromkeys(sorted({"recordings", "recordings/kept.mcap", *made}), SERVER)
