"""`movingout recordings export` as a user types it."""

import csv
from pathlib import Path

import pytest

from movingout.recordings import finalise
from movingout.server.cli import main
from tests.recordings.support import not_counted, record


def test_rounds_that_the_study_does_not_count_are_left_out_unless_they_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A round that was marked as invalid was in the tables and training sets."""
    place = tmp_path / "recordings"
    for name in ("a", "b"):
        finalise(record(place, 3, episode_id=name)[0])
    not_counted(tmp_path, "b")

    def exported(*paths: Path) -> set[str]:
        out = tmp_path / f"out-{len(paths)}"
        assert main(["recordings", "export", *map(str, paths), "--to", "csv", "-o", str(out)]) == 0
        with (out / "episodes.csv").open(encoding="utf-8") as stream:
            return {row["episode_id"] for row in csv.DictReader(stream)}

    assert exported(place) == {"a"}
    assert "left out 1 not counted by their study; name a file to export it" in capsys.readouterr().out
    assert exported(place, place / "b.mcap") == {"a", "b"}
    assert "left out" not in capsys.readouterr().out


def test_journals_are_left_out_unless_they_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A round that ran, which no study counts yet, was in the tables and training sets."""
    place = tmp_path / "recordings"
    finalise(record(place, 3, episode_id="good")[0])
    running, _ = record(place, 3, episode_id="running")
    record(place, 3, episode_id="alone")
    not_counted(tmp_path, "running")
    assert main(["recordings", "export", str(place), "--to", "csv", "-o", str(tmp_path / "all")]) == 0
    told = capsys.readouterr().out
    assert "left out 1 unfinished recording, 1 not counted by their study; name a file to export it" in told
    assert "wrote 1 recording to" in told
    assert main(["recordings", "export", str(running), "--to", "csv", "-o", str(tmp_path / "named")]) == 0
    told = capsys.readouterr().out
    assert "left out" not in told and "wrote 1 recording to" in told


@pytest.mark.parametrize(("to", "number"), [("official", 1), ("csv", 2)])
def test_recordings_without_a_tick_are_no_demonstrations(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], to: str, number: int
) -> None:
    """The card of a data set counted them."""
    finalise(record(tmp_path / "in", 3, episode_id="good")[0])
    finalise(record(tmp_path / "in", 0, "error", episode_id="empty")[0])
    assert main(["recordings", "export", str(tmp_path / "in"), "--to", to, "-o", str(tmp_path / "out")]) == 0
    assert ("left out 1 empty recording" in capsys.readouterr().out) == (number == 1)
    assert f"| episodes | {number}: " in (tmp_path / "out" / "README.md").read_text()


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("gif --test-share 0.4", "--test-share is for --to parquet, csv, lerobot, robomimic, official; with --to gif"),
        ("csv --layout official-v1", "--layout is for --to parquet, lerobot, robomimic; with --to csv it does nothing"),
        ("parquet --no-overlay", "--no-overlay is for --to mp4, gif, png"),
        ("gif --every 2", "--every is for --to png"),
        ("csv --images 96", "--images is for --to lerobot"),
        ("csv --seed 0", "--seed does nothing without --test-share"),
    ],
)
def test_options_that_do_nothing_are_refused(
    words: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Five equal GIFs, of which one was for testing, it said."""
    finalise(record(tmp_path / "in", 3)[0])
    command = ["recordings", "export", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "--to", *words.split()]
    assert main(command) == 2
    assert sentence in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_whoever_goes_on_with_demos_of_several_maps_is_told_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], recwarn: pytest.WarningsRecorder
) -> None:
    pytest.importorskip("h5py")
    for name in ("HandOff", "LeftRight"):
        finalise(record(tmp_path / "in", 3, episode_id=name, map_name=name)[0])
    command = ["recordings", "export", str(tmp_path / "in"), "--to", "robomimic", "-o", str(tmp_path / "out.hdf5")]
    assert main(command) == 0
    assert capsys.readouterr().err.startswith("movingout: env_args name HandOff as designed, but 2 of 4 demos are")
    assert not recwarn.list


@pytest.mark.parametrize("to", ["official", "robomimic"])
def test_not_even_those_that_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str], to: str) -> None:
    """They were counted as written, and were not."""
    files = [finalise(record(tmp_path, ticks, episode_id=f"e{ticks}")[0]) for ticks in (0, 3)]
    words = ["recordings", "export", "--to", to, "-o", str(tmp_path / "out.hdf5")]
    assert main([*words, *map(str, files)]) == 0
    told = capsys.readouterr().out
    assert told.startswith("left out 1 empty recording, in which nothing was played\nwrote 1 recording to")
    assert main([*words, str(files[0])]) == 2
    assert "name recordings that have a tick" in capsys.readouterr().err


def test_episodes_that_are_equal_are_not_divided_between_training_and_test(tmp_path: Path) -> None:
    """As four of the same pair of agents in which nothing is drawn: a test on what was learned by heart."""
    place = tmp_path / "recordings"
    for number in range(8):
        finalise(record(place, 4, episode_id=f"e{number}", seed=number % 4)[0])
    out = tmp_path / "out"
    words = ["--to", "csv", "-o", str(out), "--test-share", "0.5", "--split-by", "episode"]
    assert main(["recordings", "export", str(place), *words]) == 0
    with (out / "episodes.csv").open(encoding="utf-8") as stream:
        parts = {row["episode_id"]: row["split"] for row in csv.DictReader(stream)}
    assert [parts[f"e{number}"] for number in range(4)] == [parts[f"e{number + 4}"] for number in range(4)]
    assert sorted(parts.values()) == ["test"] * 4 + ["train"] * 4
