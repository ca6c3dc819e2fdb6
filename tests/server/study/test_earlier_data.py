"""Data folders written by an earlier version: a study in progress, and one whose server was killed in mid-round."""

import json
import shutil
import time
from pathlib import Path

import pytest

from movingout.recordings import verify
from movingout.recordings.storage.index import list_recordings
from movingout.server.cli import main
from movingout.study.store.tables import participants, rounds
from tests.server.study.support import Served, Visitor, served

FIXTURES = Path(__file__).parents[2] / "fixtures"
STUDY, UNFINISHED = FIXTURES / "study", FIXTURES / "unfinished_study"
ABOUT = json.loads((STUDY / "about.json").read_text(encoding="utf-8"))
KILLED_AFTER = 12  # ticks of the unfinished round that its player has seen


def returning(study: Served, name: str) -> Visitor:
    return study.visitor(PROLIFIC_PID=name, STUDY_ID="fixture", SESSION_ID="1")


NEW_COLUMNS = {"rounds.csv": 1, "allocation.csv": 2}  # at the end, since then


def test_the_export_is_the_same_to_the_byte_but_for_new_columns_at_its_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(STUDY / "data", tmp_path / "data")
    out = tmp_path / "export"
    assert main(["study", "export", str(STUDY / "study.yaml"), "--data", str(tmp_path / "data"), "-o", str(out)]) == 0
    expected = {path.name: path.read_bytes() for path in (STUDY / "expected").glob("*.csv")}
    assert len(expected) == 13
    assert {path.name: _of_before(path) for path in out.glob("*.csv")} == expected


def _of_before(path: Path) -> bytes:
    """A table without its new columns, in which nothing needs quotes."""
    new = NEW_COLUMNS.get(path.name, 0)
    return (
        b"".join(b",".join(line.split(b",")[:-new]) + b"\r\n" for line in path.read_bytes().splitlines())
        if new
        else path.read_bytes()
    )


def test_participants_are_where_they_were_and_go_on_to_their_codes(tmp_path: Path) -> None:
    data = tmp_path / "data"
    shutil.copytree(STUDY / "data", data)
    text = (STUDY / "study.yaml").read_text(encoding="utf-8")
    with served(data, text, any_device=True, agent_workers=1, tick_s=0.025) as study:
        assert study.running.study.allocation == 1, "as it began"
        for name in ("fixture-done-1", "fixture-done-2", "fixture-stopped"):
            assert returning(study, name).step["code"] == ABOUT[name]["code"]
        asked, card = returning(study, "fixture-asked"), returning(study, "fixture-card")
        assert asked.step["key"] == ABOUT["fixture-asked"]["step"]
        assert asked.step["answers"] == ABOUT["fixture-asked"]["answers"]
        assert card.kind == "paused", "as the experimenter left them"
        study.ask("resume", pid=card.pid)
        assert card.look()["step"]["key"] == ABOUT["fixture-card"]["step"]
        pids = [one.pid for one in (asked, card) if one.go_to("code")]
        store = study.running.databases.store
        outcomes = {row["pid"]: row["outcome"] for row in store.rows(participants)}
        assert [outcomes[pid] for pid in pids] == ["done", "done"]
        invalid = [row["episode"] for row in store.rows(rounds) if not row["valid"]]
        assert invalid == [ABOUT["invalid"]]
        assert study.visitor(PROLIFIC_PID="somebody-new").kind == "consent"


@pytest.mark.slow
def test_a_round_that_was_cut_off_by_a_kill_resumes_after_its_last_recorded_tick(tmp_path: Path) -> None:
    data = tmp_path / "data"
    shutil.copytree(UNFINISHED / "data", data)
    for path in (data / "rooms").glob("*.json"):  # rooms older than a day are not brought back
        path.write_text(json.dumps(json.loads(path.read_text()) | {"saved": time.time()}))
    with served(
        data, (UNFINISHED / "study.yaml").read_text(encoding="utf-8"), any_device=True, agent_workers=1
    ) as study:
        visitor = returning(study, "fixture-playing")
        assert (visitor.step["key"], visitor.step["state"]) == ("play/1/Simple-1", "playing")
        seat, person = visitor.step["room"]["seat"], visitor.player()
        assert KILLED_AFTER < person.next_tick(seat) <= KILLED_AFTER + 2
        person.play_out(seat)
        visitor.wait_until(lambda one: one.kind == "questionnaire")
        study.live.hang_up()
    (recording,), damaged = list_recordings(data / "recordings")
    assert damaged == []
    assert recording.ticks == 60 and verify(recording.path).identical
