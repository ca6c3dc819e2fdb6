"""`movingout recordings failures` as a user types it."""

import csv
import errno
import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

import pytest

from movingout.recordings.annotation.search import search_failures
from movingout.recordings.annotation.verdicts import add_verdict, new_line
from movingout.recordings.commands import failures
from movingout.server.cli import main
from tests.agents.learning import recorded
from tests.recordings.annotation.support import waiting_alone
from tests.recordings.support import not_counted


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    place = tmp_path / "recordings"
    for name in ("first", "second"):
        waiting_alone(place, name)
    return place


def test_rates_by_rules_and_by_annotators(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, second = (one.findings[0] for one in search_failures(folder).recordings)
    for finding, verdict, who in ((first, "confirmed", "Ada"), (first, "confirmed", "Bo"), (second, "rejected", "Ada")):
        add_verdict(folder, new_line(finding.id, verdict, who, note="=1+1"))
    out = tmp_path / "findings.csv"
    assert main(["recordings", "failures", str(folder), "--json", "-o", str(out)]) == 0
    document = json.loads(capsys.readouterr().out)
    rates = {(rate["who"], rate["case"]): rate for rate in document["rates"]}
    away = rates["bass@all", "stays_away"]
    assert (away["found"]["mean"], away["confirmed"]["mean"], away["found"]["n"], away["open"]) == (1.0, 0.5, 2, 0)
    assert rates["people", "stays_away"]["found"]["mean"] == 0.0
    assert document["agreement"] == [{"one": "Ada", "other": "Bo", "both": 1, "same": 1, "kappa": None}]
    with out.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["verdict"] for row in rows] == ["confirmed", "rejected"]
    assert [row["verdict Bo"] for row in rows] == ["confirmed", ""] and rows[0]["note Ada"] == "'=1+1"


def test_the_page_of_rates_says_where_to_annotate(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recordings", "failures", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "2 recordings: 2 findings by rules" in said and "open /annotate" in said
    assert "bass@all: does not come when help is needed: n = 2, by rules 1.000" in said


def test_what_was_played_again_action_by_action_is_no_second_witness(folder: Path) -> None:
    one, other = search_failures(folder).recordings
    assert one.played == other.played != "", "two episodes, played alike"
    alike, apart = (
        failures.rates_by_player([one, replace(second, findings=())], {})
        for second in (other, replace(other, played="x"))
    )
    rates = [{(rate.who, rate.case): rate.found for rate in found} for found in (alike, apart)]
    assert [one["bass@all", "stays_away"] for one in rates] == [(0.5, None, 2), (0.5, 0.5, 2)]


def test_people_of_a_rehearsal_are_called_simulated(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recorded(folder, "programs", simulated=True, kinds=("human", "agent"))
    for _ in range(2):  # the second time from the index
        assert main(["recordings", "failures", str(folder)]) == 0
        said = capsys.readouterr().out
        assert "1 recording of a rehearsal: the people in it were simulated" in said
        assert "simulated people: " in said and "  people: " in said, "those of the other recordings are people"


def test_a_folder_without_recordings_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recordings", "failures", str(tmp_path)]) == 2
    assert f"there are no finished recordings in {tmp_path}" in capsys.readouterr().err


def test_copies_and_rounds_that_the_study_does_not_count_are_left_out_and_named(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(folder / "first.mcap", folder / "again.mcap")
    not_counted(tmp_path, "second")
    out = tmp_path / "findings.csv"
    assert main(["recordings", "failures", str(folder), "-o", str(out)]) == 0
    assert "1 recording (left out: 1 not counted by their study; 1 copy): 1 finding by rules" in capsys.readouterr().out
    with out.open(encoding="utf-8") as stream:
        assert [row["recording"] for row in csv.DictReader(stream)] == ["first"]
    assert main(["recordings", "failures", str(folder), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert [document[name] for name in ("recordings", "uncounted", "copies")] == [1, 1, 1]


@pytest.mark.parametrize("command", ["failures", "split"])
def test_a_table_never_replaces_a_recording(command: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording = folder / "first.mcap"
    before = recording.read_bytes()
    assert main(["recordings", command, str(folder), "-o", str(recording)]) == 2
    assert f"{recording} is not the name of a table; it should end in .csv" in capsys.readouterr().err
    assert recording.read_bytes() == before


def test_a_full_disk_leaves_the_table_of_before(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(row: object) -> NoReturn:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(failures, "safe_cells", full)
    out = tmp_path / "findings.csv"
    out.write_text("before")
    assert main(["recordings", "failures", str(folder), "-o", str(out)]) == 2
    assert out.read_text() == "before" and not list(tmp_path.glob(".findings*"))
