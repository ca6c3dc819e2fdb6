"""What a study does not count is told apart by its database, which lies beside the recordings."""

from pathlib import Path

import pytest

from movingout.agents.errors import DataError
from movingout.agents.training.training_data import read_training_data
from movingout.recordings import finalise
from movingout.recordings.diversity.episodes import read_paths
from movingout.recordings.errors import RecordingError
from movingout.recordings.groups import grouped
from movingout.recordings.storage import study_rounds
from movingout.recordings.storage.listing import Summary, read_summary
from movingout.recordings.storage.study_rounds import counted_recordings, uncounted_episodes
from movingout.server.security.tokens import new_id
from movingout.study.data.backup import back_up
from movingout.study.store import Unit
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome, Rounds
from movingout.study.store.tables import rounds, units
from tests.recordings.support import not_counted, record
from tests.study.filled import fill, template
from tests.study.support import rounds_of

SHORT = {"    maps: [HandOff, PriorityPick, SingleRotation]": "    maps: [HandOff]"}


def test_invalid_rounds_broken_ones_and_those_of_people_who_declined_are_not_counted(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, pids = fill(tmp_path, study, text, 3, recorded_ticks=9)
    recordings = sorted(place.recordings.iterdir())
    assert uncounted_episodes(recordings) == frozenset() and len(grouped(recordings, 1)) == len(recordings)
    invalid = next(row["episode"] for row in store.rows(rounds))
    Rounds(store).mark(invalid, valid=False)
    store.keep_data(pids[1], keep=False)
    units_of = {row["pid"]: row["unit"] for row in store.rows(store.tables()["participants"])}
    declined = {row["episode"] for row in store.rows(rounds) if row["unit"] == units_of[pids[1]]}
    unit = next(row for row in store.rows(units) if row["id"] == units_of[pids[2]])
    again = Unit(unit["id"], unit["slot"], (pids[2],), paused=False)
    Rounds(store).begin(again, rounds_of(again.slot, study)[0], "running", [PlayerOutcome(pids[2], 0, "keyboard")])
    Rounds(store).begin(again, rounds_of(again.slot, study)[0], "left", [PlayerOutcome(pids[2], 0, "keyboard")])
    Rounds(store).end("left", RoundOutcome("left", 5, 0.0, 0.0, 0.0, None, 1.5))
    assert uncounted_episodes(recordings) == {invalid, *declined, "running", "left"}
    kept = {row.episode for row in grouped(recordings, 1)}
    assert kept == {path.stem for path in recordings} - {invalid} - declined
    data = read_training_data([place.recordings])
    assert {file.stem for file in data.files} == kept and data.uncounted == 1 + len(declined)
    reading = read_paths([place.recordings], workers=1)
    assert len(reading.episodes) == len(kept) and reading.uncounted == data.uncounted
    with pytest.raises(DataError, match="none of 1 recording counts: their study leaves them out"):
        read_training_data([place.recordings / f"{invalid}.mcap"])


def test_a_backup_counts_what_its_study_counted_when_it_was_made(tmp_path: Path) -> None:
    study, text = template("agent_survey", **SHORT)
    place, store, _ = fill(tmp_path / "data", study, text, 1, recorded_ticks=9)
    invalid = next(row["episode"] for row in store.rows(rounds))
    Rounds(store).mark(invalid, valid=False)
    back_up(place, tmp_path / "backup", 1_800_000_000.0)
    assert uncounted_episodes((tmp_path / "backup" / "recordings").iterdir()) == {invalid}


def test_recordings_that_have_their_own_names_are_not_read_for_a_round_without_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 20,000 recordings all were, for each training with an import: a round that never began has none."""
    folder = tmp_path / "recordings"
    own = finalise(record(folder, 2, episode_id=new_id(20))[0])
    renamed = finalise(record(folder, 2, episode_id="gone")[0]).rename(folder / "mine.mcap")
    read: list[Path] = []

    def reading(file: Path) -> Summary:
        read.append(file)
        return read_summary(file)

    monkeypatch.setattr(study_rounds, "read_summary", reading)
    assert study_rounds._recordings_of(frozenset({"gone"}), tmp_path) == read == [renamed]
    assert study_rounds._recordings_of(frozenset({own.stem}), tmp_path) == [own]


def test_a_database_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    database = tmp_path / "studies" / "mine" / "study.sqlite"
    database.parent.mkdir(parents=True)
    database.write_text("no database, but long enough to be looked at", encoding="utf-8")
    with pytest.raises(RecordingError, match=r"study\.sqlite, which says which rounds count"):
        uncounted_episodes([tmp_path / "recordings" / "one.mcap"])


def test_a_round_that_is_not_counted_is_not_counted_as_a_journal_either(tmp_path: Path) -> None:
    journals = [record(tmp_path / "recordings", 2, episode_id=name)[0] for name in ("good", "running")]
    not_counted(tmp_path, "running")
    assert counted_recordings(journals) == journals[:1]
