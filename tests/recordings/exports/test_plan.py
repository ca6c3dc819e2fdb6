"""What is refused before the first recording is converted."""

import re
from pathlib import Path

import pytest

from movingout.maps import MapSpec, load_map
from movingout.maps.json_format import map_from_json, map_to_json
from movingout.recordings import RecordingError, finalise
from movingout.recordings.exports import export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.storage.listing import read_map
from tests.recordings.support import record


@pytest.fixture
def five() -> MapSpec:
    """A map with more goals than the layout `map-v1` has numbers for."""
    goals = [{"x0": x, "y0": 1.2, "x1": x + 0.35, "y1": 0.8} for x in (-1.2, -0.75, -0.3, 0.15, 0.6)]
    return map_from_json(map_to_json(load_map("Simple")) | {"name": "Five", "goals": goals})


@pytest.mark.parametrize("name", ["parquet", "lerobot", "robomimic"])
def test_recordings_of_maps_that_a_layout_does_not_see_are_named_before_any_is_converted(
    name: str, five: MapSpec, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen, unseen = finalise(record(tmp_path, 3, episode_id="a")[0]), finalise(record(tmp_path, 3, map=five)[0])
    journal, _ = record(tmp_path, 3, episode_id="c", map=five)
    why = f"{unseen}: the layout map-v1 has 4 slots for goals; Five has 5; leave it out, and 1 other with such maps"
    monkeypatch.setattr(ExportPlan, "converted", None)
    with pytest.raises(RecordingError, match=re.escape(why)):
        export(name, ExportPlan([seen, unseen, journal], tmp_path / "x", layout="map-v1"))
    assert not (tmp_path / "x").exists()


def test_the_map_of_a_recording_is_read_alone_and_that_of_a_journal_too(
    five: MapSpec, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, journal = finalise(record(tmp_path, 3, map=five)[0]), record(tmp_path, 3, episode_id="b", map=five)[0]
    assert read_map(journal) == five
    monkeypatch.setattr("movingout.recordings.storage.listing.read_episode", None)  # a long file
    assert read_map(whole) == five
