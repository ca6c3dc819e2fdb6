"""What a server says of its data folder when it ends, and whose folder it refuses."""

import json
from pathlib import Path

import pytest

from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server.persistence.data_folder import (
    BadDataFolder,
    refuse_study_folder,
    told_interrupted,
    told_of_other_studies,
)
from movingout.server.study.arrivals.signed_links import LinkSigner
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from tests.server.study.support import SOLO

ONE, MORE = "1 round was interrupted; it goes on", "2 rounds were interrupted; they go on"


@pytest.mark.parametrize(
    ("playing", "ended", "said"),
    [
        ("", "", ""),
        ("a", "", f"{ONE} when the server is started again. "),
        ("ab", "", f"{MORE} when the server is started again. "),
        ("", "c", "1 recording is not finished; the next start finishes it. "),
        (
            "a",
            "cd",
            f"{ONE} when the server is started again. 2 recordings are not finished; the next start finishes them. ",
        ),
    ],
)
def test_only_rounds_that_are_still_recorded_are_said_to_go_on(
    tmp_path: Path, playing: str, ended: str, said: str
) -> None:
    """A full disk ends a recording and not the round; the room does not go on with its journal."""
    for folder in ("recordings", "rooms"):
        (tmp_path / folder).mkdir()
    for episode in playing + ended:
        (tmp_path / "recordings" / f"{episode}{JOURNAL_SUFFIX}").write_bytes(b"")
        room = {"id": f"room-{episode}", "episode": episode if episode in playing else ""}
        (tmp_path / "rooms" / f"room-{episode}.json").write_text(str(room).replace("'", '"'))
    (tmp_path / "rooms" / "damaged.json").write_text("{")
    recover = f"To end now: movingout recordings recover {tmp_path / 'recordings'}{' --all' if playing else ''}"
    assert told_interrupted(tmp_path) == (said + recover if said else "")


def test_rounds_of_other_studies_wait_and_the_start_says_so(tmp_path: Path) -> None:
    for folder in ("recordings", "rooms"):
        (tmp_path / folder).mkdir()
    for episode, study in {"a": "one", "b": "two", "c": "two", "d": "mine"}.items():
        (tmp_path / "recordings" / f"{episode}{JOURNAL_SUFFIX}").write_bytes(b"")
        room = {"id": f"room-{episode}", "episode": episode, "config": {"study": {"study": study}}}
        (tmp_path / "rooms" / f"room-{episode}.json").write_text(json.dumps(room))
    assert told_of_other_studies(tmp_path, "mine").splitlines() == [
        "1 round of the study one was interrupted; it goes on when that study is served again.",
        "2 rounds of the study two were interrupted; they go on when that study is served again.",
    ]
    mine = tmp_path / "recordings" / f"d{JOURNAL_SUFFIX}"
    again = "when the server is started again. To end now:"
    assert told_interrupted(tmp_path, "mine") == f"{ONE} {again} movingout recordings recover {mine}", "others go on"
    assert told_of_other_studies(tmp_path / "recordings", "mine") == ""


def test_a_study_that_was_refused_before_it_began_leaves_the_folder_to_games(tmp_path: Path) -> None:
    with StudyFolder(parse_study(SOLO, "study.yaml"), tmp_path).exclusive():
        pass  # as where its file has blanks, or the port is in use
    refuse_study_folder(tmp_path)


def test_a_study_with_a_key_of_links_may_have_been_served_from_postgresql(tmp_path: Path) -> None:
    folder = StudyFolder(parse_study(SOLO, "study.yaml"), tmp_path)
    with folder.exclusive():
        LinkSigner.in_folder(folder.own, "solo")
    with pytest.raises(BadDataFolder, match=r"holds a study \(solo\), whose recordings are not for players"):
        refuse_study_folder(tmp_path)
