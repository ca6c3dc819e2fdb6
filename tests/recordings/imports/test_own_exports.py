"""What our own export wrote comes back once, with who played it."""

import json
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from movingout.recordings import SeatInfo, finalise, read_episode
from movingout.recordings.episode import SeatKind
from movingout.recordings.exports import export
from movingout.recordings.exports.plan import ExportPlan
from movingout.server.cli import main
from tests.recordings.support import evaluator_steps, record

SEATS = (SeatInfo("human", "P-1"), SeatInfo("agent", "scripted"))


@pytest.fixture
def exported(tmp_path: Path) -> Path:
    recording, _ = record(tmp_path, ticks=8, episode_id="first", map_name="LeftRight", seats=SEATS)
    export("official", ExportPlan([finalise(recording)], tmp_path / "out"))
    return tmp_path / "out"


def kinds(folder: Path) -> list[tuple[str, ...]]:
    return [tuple(seat.kind for seat in read_episode(path).header.seats) for path in folder.glob("*.mcap")]


def test_an_exported_folder_comes_back_once_with_the_kinds(
    exported: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["recordings", "import", str(exported), "--out", str(tmp_path / "in"), "--workers", "1"]) == 0
    assert "copies: 1 more" in capsys.readouterr().out
    assert kinds(tmp_path / "in") == [("human", "agent")]
    episode = read_episode(next((tmp_path / "in").glob("*.mcap")))
    assert episode.header.seats[1].name == "scripted"
    assert episode.header.seats[0].name not in ("", "P-1")  # a person's name becomes a pseudonym
    assert {tick.sources for tick in episode.ticks} == {("human", "agent")}


def test_what_our_commands_put_beside_trajectories_does_not_stop_an_import(
    exported: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (exported / "in").mkdir()
    (exported / "in" / ".verified.json").write_text("{}")
    others = {"people.json": "{}", "notes.jsonl": '{"a": 1}', "numbers.json": "[1, 2]"}
    for name, text in others.items():
        (exported / name).write_text(text)
    command = ["recordings", "import", "--out", str(tmp_path / "in"), "--workers", "1"]
    assert main([*command, str(exported)]) == 0
    said = capsys.readouterr().err
    assert all(f"left out: {exported / name}, which has no trajectories" in said for name in others)
    assert ".verified" not in said and len(kinds(tmp_path / "in")) == 1
    assert main([*command, str(exported / "people.json")]) == 2
    assert f"{exported / 'people.json'}: a list of episodes is needed" in capsys.readouterr().err


def imported_again(tmp_path: Path, *options: str) -> list[str]:
    """The command that imports the export of one recording that ran out of time after eight ticks of eight."""
    recording, _ = record(tmp_path, ticks=8, map_name="LeftRight", limit_ticks=8)
    export("official", ExportPlan([finalise(recording)], tmp_path / "out"))
    return ["recordings", "import", *options, "--out", str(tmp_path / "in"), "--workers", "1"]


@pytest.mark.parametrize("shape", ["dataset.jsonl", "dataset.parquet"])
def test_an_episode_out_of_time_comes_back_as_one(tmp_path: Path, shape: str) -> None:
    """It was "stopped", which reports leave out: averages were those of successes alone."""
    command = imported_again(tmp_path, str(tmp_path / "out" / shape))
    rows = [json.loads(line) for line in (tmp_path / "out" / "dataset.jsonl").read_text().splitlines()]
    pq.write_table(pa.Table.from_pylist(rows), tmp_path / "out" / "dataset.parquet")
    assert main(command) == 0
    episode = read_episode(next((tmp_path / "in").glob("*.mcap")))
    assert (episode.outcome, episode.header.limit_ticks) == ("time", 8)


@pytest.mark.parametrize(("limit", "outcome"), [("8", "time"), ("500", "stopped")])
def test_where_a_file_does_not_say_its_limit_an_option_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], limit: str, outcome: str
) -> None:
    assert main([*imported_again(tmp_path, str(tmp_path / "out" / "recorder")), "--limit-ticks", limit]) == 0
    said = "1 ended undelivered before 500 ticks, and are left out of averages" in capsys.readouterr().out
    episode = read_episode(next((tmp_path / "in").glob("*.mcap")))
    assert (episode.outcome, episode.header.limit_ticks, said) == (outcome, int(limit), outcome == "stopped")


def test_an_episode_without_a_tick_is_not_exported(exported: Path, tmp_path: Path) -> None:
    """It was `[[]]`, which the import refused with all the others."""
    empty, _ = record(tmp_path, ticks=0, outcome="error", episode_id="empty", map_name="LeftRight")
    files = [*tmp_path.glob("*.mcap"), finalise(empty)]
    export("official", ExportPlan(files, tmp_path / "both"))
    assert [file.name for file in (tmp_path / "both" / "recorder").iterdir()] == ["LeftRight_first.json"]


@pytest.mark.parametrize("shape", ["recorder", "dataset.jsonl", "evaluator.json"])
def test_beside_the_recording_that_it_was_made_from_nothing_is_imported(
    exported: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], shape: str
) -> None:
    (recording,) = tmp_path.glob("*.mcap")
    (exported / "evaluator.json").write_text(json.dumps([evaluator_steps(read_episode(recording))]))
    (tmp_path / "damaged.mcap").write_bytes(b"rubbish")
    command = ["recordings", "import", str(exported / shape), "--out", str(tmp_path), "--workers", "1"]
    assert main(command) == 0
    assert f"recorded already, as {recording.name}" in capsys.readouterr().out
    assert {path.name for path in tmp_path.glob("*.mcap")} == {recording.name, "damaged.mcap"}


def test_another_play_is_imported_beside_it(exported: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (file,) = (exported / "recorder").iterdir()
    episodes = json.loads(file.read_text())
    episodes[0][3]["action"][0][0] += 0.25
    file.write_text(json.dumps(episodes))
    main(["recordings", "import", str(file), "--out", str(tmp_path), "--workers", "1"])
    assert "1 of 1 trajectories imported" in capsys.readouterr().out
    assert len(list(tmp_path.glob("*.mcap"))) == 2


@pytest.mark.parametrize("kind", ["remote", "ghost", "idle"])
def test_every_kind_of_seat_is_kept(tmp_path: Path, kind: SeatKind) -> None:
    seats = (SeatInfo(kind, "mine"), SeatInfo("human", "P-1"))
    recording, _ = record(tmp_path, ticks=8, map_name="LeftRight", seats=seats)
    export("official", ExportPlan([finalise(recording)], tmp_path / "out"))
    rows = str(tmp_path / "out" / "dataset.jsonl")
    assert main(["recordings", "import", rows, "--out", str(tmp_path / "in"), "--workers", "1"]) == 0
    assert kinds(tmp_path / "in") == [(kind, "human")]


@pytest.mark.parametrize("kind", ["human", "agent"])
def test_the_kind_can_be_said(exported: Path, tmp_path: Path, kind: str) -> None:
    command = ["recordings", "import", str(exported / "recorder"), "--out", str(tmp_path / "in"), "--kind", kind]
    assert main([*command, "--workers", "1"]) == 0
    assert kinds(tmp_path / "in") == [(kind, kind)]


def test_a_kind_said_for_a_trajectory_that_was_imported_before_changes_nothing_and_says_so(
    exported: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["recordings", "import", str(exported / "recorder"), "--out", str(tmp_path / "in"), "--workers", "1"]
    assert main([*command, "--kind", "human"]) == 0
    (path,) = (tmp_path / "in").glob("*.mcap")
    before = path.read_bytes()
    capsys.readouterr()
    assert main([*command, "--kind", "agent"]) == 0
    out = capsys.readouterr().out
    assert "0 of 1 trajectories imported" in out
    assert "imported before, with human in blue and human in red; nothing changed." in out
    assert f"To import it otherwise, move {path.name} away" in out
    assert path.read_bytes() == before


def test_angles_in_other_units_are_told_apart_from_places(
    exported: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Such a file drifted "up to 0"."""
    rows = (exported / "dataset.jsonl").read_text().splitlines()
    row = json.loads(rows[0])
    steps = json.loads(row["steps_data"])
    for step in steps[1:]:
        step[1]["robot_1"]["angle"] += 1.0
    file = tmp_path / "degrees.jsonl"
    file.write_text(json.dumps(row | {"steps_data": json.dumps(steps)}))
    assert main(["recordings", "import", str(file), "--out", str(tmp_path / "in"), "--workers", "1"]) == 0
    assert "(LeftRight) from tick 1, in angles [rad] or hands alone" in capsys.readouterr().out


@pytest.mark.parametrize("shape", ["dataset.jsonl", "dataset.parquet"])
@pytest.mark.parametrize("simulated", [True, False])
def test_programs_of_a_rehearsal_do_not_come_back_as_people(tmp_path: Path, simulated: bool, shape: str) -> None:
    study = {"simulated": "yes"} if simulated else {}
    recording, _ = record(tmp_path, ticks=8, map_name="LeftRight", seats=SEATS, study=study)
    export("official", ExportPlan([finalise(recording)], tmp_path / "out"))
    rows = [json.loads(line) for line in (tmp_path / "out" / "dataset.jsonl").read_text().splitlines()]
    pq.write_table(pa.Table.from_pylist(rows), tmp_path / "out" / "dataset.parquet")
    source = str(tmp_path / "out" / shape)
    assert main(["recordings", "import", source, "--out", str(tmp_path / "in"), "--workers", "1"]) == 0
    (path,) = (tmp_path / "in").glob("*.mcap")
    assert read_episode(path).header.simulated == simulated
