"""Who asks for the deletion of their data: recordings that somebody else finishes go too, whenever they come."""

import shutil
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

from movingout.recordings import finalise
from movingout.recordings.episode import SeatInfo
from movingout.recordings.storage.index import list_recordings
from movingout.server.persistence.recording_service import RecordingService
from movingout.server.study import deletions
from movingout.study.errors import StudyError
from movingout.study.store.database import Database
from movingout.study.store.removal import withdraw_data
from movingout.study.store.store import Store
from movingout.study.store.tables import answers, notes
from tests.recordings.support import record
from tests.server.cluster.processes import wait_until
from tests.server.study.support import Served, Visitor, served


def journal_of(visitor: Visitor, folder: Path) -> Path:
    """One that another node has closed, of a round that this participant has played."""
    seats = (SeatInfo("human", visitor.pid), SeatInfo("agent", "idle"))
    return record(folder, ticks=3, episode_id="elsewhere", seats=seats)[0]


def names_in(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir() if path.suffix in (".mcap", ".journal")]


@pytest.mark.slow
def test_a_recording_that_another_node_finishes_is_waited_for(tmp_path: Path) -> None:
    recordings = tmp_path / "recordings"
    with served(tmp_path) as study:
        visitor = study.visitor().go_to("questionnaire")
        journal = journal_of(visitor, recordings)
        visitor.stop(False)
        time.sleep(1.5)
        assert journal.exists(), "or the other node writes a recording of what is deleted"
        finalise(journal)
        wait_until(lambda: not names_in(recordings), "nothing is left")
        wait_until(lambda: not study.running.databases.store.rows(answers), "no answer either")


@pytest.mark.slow
def test_a_recording_that_comes_after_the_deletion_is_deleted_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(deletions, "LOOK_AGAIN_S", (1.0, 1.0, 1.0, 1.0))
    recordings = tmp_path / "recordings"
    with served(tmp_path) as study:
        visitor = study.visitor().go_to("questionnaire")
        late = finalise(journal_of(visitor, tmp_path))
        visitor.stop(False)
        wait_until(lambda: not names_in(recordings), "the deletion")
        shutil.move(late, recordings / late.name)
        wait_until(lambda: not names_in(recordings), "nothing is left")


@pytest.mark.slow
def test_the_next_start_deletes_what_came_while_nobody_looked(tmp_path: Path) -> None:
    recordings = tmp_path / "recordings"
    with served(tmp_path) as study:
        visitor = study.visitor().go_to("questionnaire")
        other = study.visitor().go_to("questionnaire")
        visitor.stop(False)
    kept = {path.name for path in recordings.glob("*.mcap")}
    finalise(journal_of(visitor, recordings))
    with served(tmp_path):
        wait_until(lambda: {path.name for path in recordings.glob("*.mcap")} == kept, "what came is deleted")
    assert any(other.pid in one.blue + one.red for one in list_recordings(recordings)[0])


@pytest.mark.slow
def test_a_deletion_that_failed_is_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deletions, "LOOK_AGAIN_S", (0.3,))
    faults = [StudyError("the disk hung"), TypeError("a fault of any kind ended the deletion silently")]
    really = withdraw_data

    def failing(store: Store, recordings: Mapping[str, int]) -> int:
        if faults:
            raise faults.pop()
        return really(store, recordings)

    monkeypatch.setattr(deletions, "withdraw_data", failing)
    with served(tmp_path) as study:
        study.visitor().go_to("questionnaire").stop(False)
        wait_until(lambda: not study.running.databases.store.rows(answers), "nothing is left")
        assert study.alerts().count("deletion") == 1 and not names_in(tmp_path / "recordings")


def test_notes_on_somebody_go_with_their_data_also_where_they_are_shown(solo: Served) -> None:
    visitor = solo.visitor().go_to("practice")
    solo.ask("note", text="Felt sick.", pid=visitor.pid)
    solo.ask("note", text=f"Call {visitor.pid} again.")
    solo.ask("note", text="It rained.")
    visitor.stop(False)
    wait_until(lambda: visitor.pid not in str(solo.state()["notes"]), "the deletion")
    texts = [note["text"] for note in solo.state()["notes"]]
    assert "It rained." in texts and "Felt sick." not in texts
    assert "Felt sick." not in str(solo.running.databases.store.rows(notes))


def test_who_leaves_before_the_game_costs_no_look_at_the_recordings(
    solo: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Anybody with the link can do that a thousand times a minute."""
    looks = count_calls(monkeypatch, RecordingService, "compute")
    scrubs = count_calls(monkeypatch, Database, "scrub")
    visitors = [solo.visitor() for _ in range(8)]
    for visitor in visitors:
        visitor.agree()
        visitor.answer_all()
        visitor.stop(False)
    left = {visitor.pid for visitor in visitors}
    store = solo.running.databases.store
    wait_until(lambda: not left & {row["pid"] for row in store.rows(answers)}, "the deletion")
    assert not looks and scrubs.count(store.database) <= 1
    solo.running.deletions._scrub_at = 0.0
    wait_until(lambda: not solo.running.deletions._unscrubbed, "the overwriting")
    assert scrubs.count(store.database) <= 2, "one at the first deletion, one for all that came after it"


def test_the_database_overwrites_what_was_deleted_once_a_minute_and_at_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scrubs = count_calls(monkeypatch, Database, "scrub")
    with served(tmp_path) as study:
        store = study.running.databases.store
        for _ in range(3):
            visitor = study.visitor()
            visitor.agree()
            visitor.answer_all()
            visitor.stop(False)
            wait_until(lambda: not store.rows(answers), "the deletion")
        assert scrubs.count(store.database) <= 1
    assert scrubs.count(store.database) == 2, "what was deleted since, at the latest now"


@pytest.mark.slow
def test_a_start_looks_once_for_who_left_before_and_overwrites_only_after_a_kill(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(deletions, "LOOK_AGAIN_S", (0.1, 0.1, 0.1))
    with served(tmp_path) as study:
        visitor = study.visitor().go_to("practice")
        visitor.stop(False)
        wait_until(lambda: not study.running.databases.store.rows(answers), "the deletion")
    scrubs, looks = count_calls(monkeypatch, Database, "scrub"), count_calls(monkeypatch, deletions.Deletions, "_look")
    with served(tmp_path) as study:
        wait_until(lambda: looks and not study.running.deletions._wishes, "the look")
        assert (len(looks), study.running.deletions._unscrubbed) == (1, False)
        database = study.running.databases.store.database
        with database.write() as connection:
            database.mark_deleted(connection)  # as a deletion does, and then it is killed
    assert not scrubs
    with served(tmp_path) as study:
        wait_until(lambda: study.running.deletions._unscrubbed, "the mark is read")
    assert len(scrubs) == 1, "at the end at the latest"
    with served(tmp_path) as study:
        assert not study.running.deletions._unscrubbed


def count_calls(monkeypatch: pytest.MonkeyPatch, owner: type, name: str) -> list[object]:
    calls: list[object] = []
    really = getattr(owner, name)

    def counted(self: object, *args: object, **kwargs: object) -> object:
        calls.append(self)
        return really(self, *args, **kwargs)

    monkeypatch.setattr(owner, name, counted)
    return calls
