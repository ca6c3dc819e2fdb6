"""What a server says of its data folder when it ends."""

import json
from pathlib import Path

import pytest

from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server.persistence.data_folder import told_interrupted, told_of_other_studies

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
