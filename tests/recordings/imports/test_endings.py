"""How an imported episode ended: averages are of those that were delivered or ran out of time."""

import json
from pathlib import Path
from typing import Any

import pytest

from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.match import Match
from movingout.recordings import Episode, finalise, read_episode, verify
from movingout.recordings.exports import export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.imports.convert import ImportReport, import_source
from movingout.recordings.imports.sources import read
from movingout.server.cli import main
from tests.recordings.support import record


@pytest.fixture(scope="module")
def delivered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Our own export of a variant that was delivered: its items have other masses than those of the map."""
    folder = tmp_path_factory.mktemp("delivered")
    (result,) = Lockstep(record=folder).play([Match("Simple", "scripted", "scripted", 0, challenge=2)])
    assert result.ending == "delivered"
    export("official", ExportPlan([Path(result.recording)], folder / "out"))
    return folder / "out"


def row_of(exported: Path) -> dict[str, Any]:
    return dict(json.loads((exported / "dataset.jsonl").read_text()))


def imported(row: dict[str, Any], folder: Path) -> tuple[ImportReport, Episode]:
    folder.mkdir(exist_ok=True)
    (folder / "rows.jsonl").write_text(json.dumps(row))
    report = import_source(read(folder / "rows.jsonl")[0], folder / "in", "salt")
    return report, read_episode(folder / "in" / report.recording)


def test_a_variant_that_was_delivered_comes_back_so(delivered: Path, tmp_path: Path) -> None:
    """It drifted, lacked its last tick and counted as stopped, so that averages were those of failures alone."""
    report, episode = imported(row_of(delivered), tmp_path)
    assert (report.drift_tick, report.last_tick, report.outcome_known) == (-1, "simulated", True)
    assert episode.outcome == "delivered"
    assert verify(tmp_path / "in" / report.recording).identical


@pytest.mark.parametrize("masses", [None, "heavy", [], ["1"], [True], [0.0], [float("nan")]])
def test_masses_that_are_none_are_those_of_the_map(delivered: Path, tmp_path: Path, masses: object) -> None:
    report, _ = imported(row_of(delivered) | {"masses": masses}, tmp_path)
    assert (report.drift_tick >= 0, report.last_tick) == (True, "left out")


@pytest.mark.parametrize("limit", [500, 1])
def test_a_delivery_whose_tick_is_left_out_is_no_failure(delivered: Path, tmp_path: Path, limit: int) -> None:
    report, episode = imported(row_of(delivered) | {"masses": None, "limit_ticks": limit}, tmp_path)
    assert (episode.outcome, report.outcome_known) == ("stopped", False)


@pytest.mark.parametrize("shape", ["recorder", "dataset.jsonl"])
def test_without_their_last_tick_nobody_is_told_to_shorten_the_limit(
    delivered: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], shape: str
) -> None:
    """With a shorter limit, episodes that were delivered became failures."""
    source = delivered / shape
    if shape == "dataset.jsonl":
        source = tmp_path / "rows.jsonl"
        source.write_text(json.dumps(row_of(delivered) | {"masses": None}))
    assert main(["recordings", "import", str(source), "--out", str(tmp_path / "in"), "--workers", "1"]) == 0
    said = capsys.readouterr().out
    assert "! 1 ended undelivered without their last tick, which does not re-simulate: they may have been" in said
    assert "--limit-ticks" not in said


def test_what_was_interrupted_is_imported_once(tmp_path: Path) -> None:
    """It was taken for an import that was cut off, and written anew each time."""
    journal, _ = record(tmp_path, ticks=8, map_name="LeftRight")
    export("official", ExportPlan([finalise(journal)], tmp_path / "out"))
    row = row_of(tmp_path / "out") | {"outcome": "interrupted"}
    report, episode = imported(row, tmp_path)
    assert (episode.outcome, episode.complete, report.outcome_known) == ("stopped", True, True)
    assert imported(row, tmp_path)[0].unchanged == "imported before; nothing changed"
