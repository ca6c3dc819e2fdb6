"""Recordings written by an earlier version: they open, re-simulate to the bit, and say what they said then."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from movingout.recordings import read_episode, verify
from movingout.recordings.storage.index import list_recordings
from movingout.server.cli import main
from movingout.world.metrics import METRICS

FOLDER = Path(__file__).parents[1] / "fixtures" / "recordings"
EXPECTED = json.loads((FOLDER / "expected.json").read_text(encoding="utf-8"))
JOURNAL = "2st75t4ad388gst7egct.mcap.journal"
KILLED_AFTER = 12  # ticks that the player of the journal had seen
STORED_THEN = ("tcr", "nfd", "wt_s", "ac")


Printed = Callable[..., dict[str, Any]]


@pytest.fixture
def printed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Printed:
    """What a command prints as JSON, started in the folder of the fixtures."""
    monkeypatch.chdir(FOLDER)

    def run(*words: str) -> dict[str, Any]:
        assert main([*words, "--json"]) == 0
        document: dict[str, Any] = json.loads(capsys.readouterr().out)
        return document

    return run


@pytest.mark.parametrize("name", EXPECTED)
def test_an_earlier_recording_is_verified_as_it_was(name: str, printed: Printed) -> None:
    assert printed("recordings", "verify", name) == EXPECTED[name]["verify_json"]


@pytest.mark.parametrize("name", EXPECTED)
def test_info_has_every_field_it_had_with_the_same_value(name: str, printed: Printed) -> None:
    expected, found = EXPECTED[name]["info"], printed("recordings", "info", name)
    assert found["metrics"].keys() - expected["metrics"].keys() == {metric.key for metric in METRICS} - {*STORED_THEN}
    found["metrics"] = {key: found["metrics"][key] for key in expected["metrics"]}
    assert {key: found[key] for key in expected} == expected


def test_a_metric_that_an_earlier_recording_did_not_store_is_none(tmp_path: Path) -> None:
    for name in EXPECTED:
        shutil.copy(FOLDER / name, tmp_path)
    summaries, damaged = list_recordings(tmp_path)
    assert (len(summaries), damaged) == (len(EXPECTED), [])
    again, _ = list_recordings(tmp_path)  # from the index
    assert again == summaries
    for summary in summaries:
        then = EXPECTED[summary.path.name]["info"]["metrics"]
        assert (summary.metrics["tcr"], summary.metrics["nfd"]) == (then["tcr"], then["nfd"])
        assert summary.metrics["ac"] is None and then["ac"] == -1.0
        assert summary.metrics["interdependence"] is None


def test_the_journal_of_a_killed_server_is_recovered_and_verified(tmp_path: Path) -> None:
    shutil.copy(FOLDER / JOURNAL, tmp_path)
    assert main(["recordings", "recover", str(tmp_path)]) == 0
    (path,) = tmp_path.glob("*.mcap")
    episode = read_episode(path)
    assert (episode.outcome, episode.complete) == ("interrupted", False)
    assert len(episode.ticks) >= KILLED_AFTER and verify(path).identical
