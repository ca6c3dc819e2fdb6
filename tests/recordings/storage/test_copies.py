"""Recordings beside what was imported of their own export: nobody counts twice, nor in two groups."""

import json
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.training.training_data import read_training_data
from movingout.matches.errors import MatchError
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.data_sets import listed_episodes
from movingout.matches.paper.workspace import Workspace
from movingout.recordings import Episode, SeatInfo, TickRecord, finalise, read_episode
from movingout.recordings.commands.selection import selected
from movingout.recordings.diversity.episodes import read_paths
from movingout.recordings.exports import export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.groups import grouped, is_varied, read_groups
from movingout.recordings.imports import map_match
from movingout.recordings.imports.convert import import_source
from movingout.recordings.imports.sources import find, read
from movingout.recordings.storage import copies
from movingout.recordings.storage.copies import without_copies
from movingout.recordings.storage.study_rounds import counted_recordings
from movingout.server.cli import main
from tests.recordings.support import STARTED_NS, begin, not_counted, record

A_MINUTE = 60_000_000_000  # ns


def imported(places: list[Path], folder: Path, decimals: int = 99, salt: str = "salt") -> list[Path]:
    """Our official export of recordings, imported."""
    export("official", ExportPlan(places, folder.with_name(f"{folder.name}-export")))
    made = []
    for file in find([folder.with_name(f"{folder.name}-export") / "recorder"]):
        rounded = json.loads(file.read_text(), parse_float=lambda number: round(float(number), decimals))
        file.write_text(json.dumps(rounded))
        made += [folder / import_source(source, folder, salt).recording for source in read(file)]
    return sorted(made)


@pytest.fixture
def recordings(tmp_path: Path) -> list[Path]:
    """Two pairs, and a third episode that is as long."""
    made = []
    for number in range(3):
        seats = SeatInfo("human", f"P{2 * (number % 2)}"), SeatInfo("human", f"P{2 * (number % 2) + 1}")
        folder, name = tmp_path / "both" / "recordings", f"e{number}"
        journal, _ = record(folder, ticks=12, episode_id=name, seats=seats, seed=number, map_name="LeftRight")
        made.append(finalise(journal))
    return made


def idle(folder: Path, ticks: int, started_ns: int = STARTED_NS) -> Path:
    """An episode in which nobody does anything."""
    writer, played = begin(folder, map_name="LeftRight", episode_id=f"idle-{ticks}", started_ns=started_ns)
    for _ in range(ticks):
        played.world.step(np.zeros((2, 3)))
        after, delivered = played.world.state(), tuple(played.world.delivered().tolist())
        writer.tick(TickRecord(np.zeros((2, 3)), ("human", "human"), (-1, -1), after, delivered, 0.0))
    return finalise(writer.close("time"))


@pytest.mark.parametrize("decimals", [99, 6, 3])
def test_an_import_beside_its_recordings_is_a_copy(tmp_path: Path, recordings: list[Path], decimals: int) -> None:
    made = imported(recordings, tmp_path / "both" / "imported", decimals)
    assert len(made) == 3 and not any(map(is_varied, made))
    assert without_copies([*made, *recordings]) == recordings
    assert [row.path for row in grouped([*made, *recordings], 2)] == recordings
    assert len(read_training_data([tmp_path / "both"]).trajectories) == 3
    reading = read_paths([tmp_path / "both"], workers=1)
    assert (len(reading.episodes), reading.copies) == (3, 3)


@pytest.mark.parametrize("folders", [["recordings", "imported", "again"], ["imported", "again"]])
@pytest.mark.parametrize("renamed", [False, True])
def test_an_import_of_an_episode_that_its_study_does_not_count_is_not_counted(
    tmp_path: Path, recordings: list[Path], folders: list[str], renamed: bool
) -> None:
    """Nor is one that was imported twice, or is named without its recording, whatever the name of that."""
    for folder in ("imported", "again"):
        imported(recordings, tmp_path / "both" / folder, decimals=3, salt=folder)
    not_counted(tmp_path / "both", "e1")
    if renamed:
        recordings[1].rename(recordings[1].with_name("zz.mcap"))
    named = [tmp_path / "both" / folder for folder in folders]
    files = [file for folder in named for file in sorted(folder.iterdir())]
    assert len(counted_recordings(files)) == 2 * len(folders) < len(files)
    data = read_training_data(named)
    assert (len(data.files), data.uncounted, len(data.copies)) == (2, len(folders), 2 * len(folders) - 2)
    reading = read_paths(named, workers=1)
    assert (len(reading.episodes), reading.uncounted, reading.copies) == (2, len(folders), 2 * len(folders) - 2)
    assert len(read_paths(named, workers=1, by_place=True).episodes) == 2 * len(folders)
    chosen = selected(files)
    assert (len(chosen.paths), chosen.uncounted) == (2, len(folders))
    assert len(grouped(files, 1)) == 2


def test_between_two_places_too_an_import_is_a_copy(tmp_path: Path, recordings: list[Path]) -> None:
    """A player was there twice: as recorded, and under a pseudonym."""
    made = imported(recordings, tmp_path / "imported")
    official = tmp_path / "imported-export" / "recorder"
    for places in ([made[0].parent, recordings[0].parent], [official, recordings[0].parent, made[0].parent]):
        reading = read_paths(places, workers=1)
        assert sorted(one.file for one in reading.episodes) == list(map(str, recordings))
        assert reading.copies == 3 * (len(places) - 1)
    assert len(read_paths([made[0].parent, recordings[0].parent], workers=1, by_place=True).episodes) == 6


@pytest.fixture
def varied(tmp_path: Path, recordings: list[Path], monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Rounded exports as earlier versions imported them: as of a varied map."""
    with monkeypatch.context() as earlier:
        earlier.setattr(map_match, "is_as_designed", lambda designed, found: False)
        made = imported(recordings, tmp_path / "both" / "earlier", decimals=6)
    assert all(map(is_varied, made))
    return made


def test_no_play_is_of_both_challenges(
    tmp_path: Path, recordings: list[Path], varied: list[Path], capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["recordings", "split", str(tmp_path / "both"), "-o", str(tmp_path / "c.csv"), "--challenge"]
    assert main([*command, "1"]) == 0 and len(read_groups(tmp_path / "c.csv")) == 3
    assert "3 left out, 3 copies among them" in capsys.readouterr().out
    assert main([*command, "2"]) == 2
    assert "none of 3 recordings is on a varied map" in capsys.readouterr().err
    with pytest.raises(MatchError, match="none of 6 recordings is on a varied map"):
        listed_episodes(2, Workspace(budget=BUDGETS["smoke"], given=(tmp_path / "both",)))


def test_of_two_imports_the_one_on_the_map_as_designed_stays(
    tmp_path: Path, recordings: list[Path], varied: list[Path]
) -> None:
    """Of one file their ids are the same."""
    for decimals in (6, 5):
        made = imported(recordings, tmp_path / f"in-{decimals}", decimals)
        assert not any(map(is_varied, made)) and without_copies([*varied, *made]) == made


def test_an_import_without_its_recording_stays(tmp_path: Path, recordings: list[Path]) -> None:
    made = imported(recordings, tmp_path / "both" / "imported")
    assert len(without_copies([*made, *recordings[1:]])) == 3
    assert without_copies(made) == made


def test_of_two_imports_of_one_play_the_first_stays(tmp_path: Path, recordings: list[Path]) -> None:
    whole = imported(recordings, tmp_path / "whole")
    rounded = imported(recordings, tmp_path / "rounded", decimals=5, salt="another")
    assert without_copies([*whole, *rounded]) == whole


def test_plays_that_are_equal_but_not_imported_stay(tmp_path: Path) -> None:
    """Agents in which nothing is drawn play the same for every seed."""
    same = [finalise(record(tmp_path / name, ticks=8, episode_id=name, started_ns=1)[0]) for name in ("one", "other")]
    assert without_copies(same) == same


@pytest.mark.parametrize("more", [0, 1])
def test_where_nobody_does_anything_nobody_else_is_a_copy(tmp_path: Path, more: int) -> None:
    """Two people vanished who had waited as long as two others."""
    (made,) = imported([idle(tmp_path / "theirs", 15 + more)], tmp_path / "imported")
    ours = idle(tmp_path / "ours", 15, started_ns=STARTED_NS + A_MINUTE)
    assert without_copies([ours, made]) == [ours, made]
    assert without_copies([tmp_path / "theirs" / f"idle-{15 + more}.mcap", made, ours])[1:] == [ours], "its own is one"


def test_what_is_too_short_proves_nothing(tmp_path: Path) -> None:
    (made,) = imported([finalise(record(tmp_path, ticks=3)[0])], tmp_path / "imported")
    ours = finalise(record(tmp_path / "ours", ticks=3, started_ns=STARTED_NS + A_MINUTE)[0])
    assert without_copies([ours, made]) == [ours, made]


def test_a_recording_of_no_tick_is_no_copy(tmp_path: Path) -> None:
    (made,) = imported([finalise(record(tmp_path, ticks=1)[0])], tmp_path / "imported")
    empty = finalise(begin(tmp_path / "failed", episode_id="failed")[0].close("error"))
    assert without_copies([empty, made]) == [empty, made]


def test_only_what_ends_alike_is_read_whole(
    tmp_path: Path, recordings: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Episodes that are out of time are all as long."""
    made = imported(recordings[:1], tmp_path / "imported")
    longer = finalise(record(tmp_path, ticks=30, map_name="LeftRight", episode_id="longer")[0])
    elsewhere = finalise(record(tmp_path, ticks=12, map_name="HandOff", episode_id="elsewhere")[0])
    read_whole: list[Path] = []

    def counting(path: Path) -> Episode:
        read_whole.append(path)
        return read_episode(path)

    monkeypatch.setattr(copies, "read_episode", counting)
    others = [*made, longer, elsewhere, *recordings[1:]]
    assert without_copies(others) == others and read_whole == []
    assert without_copies([*made, *recordings]) == recordings and len(read_whole) == 2


def test_a_damaged_recording_stays(tmp_path: Path, recordings: list[Path]) -> None:
    made = imported(recordings[:1], tmp_path / "imported")
    recordings[0].write_bytes(recordings[0].read_bytes()[:-40])
    assert without_copies([*made, recordings[0]]) == [*made, recordings[0]]
