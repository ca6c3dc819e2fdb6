"""What is looked at before the first recording is converted."""

import csv
import json
import re
from pathlib import Path

import h5py
import pyarrow.parquet as pq
import pytest

from movingout.maps import MapSpec, load_map
from movingout.maps.json_format import map_from_json, map_to_json
from movingout.recordings import RecordingError, finalise
from movingout.recordings.exports import export
from movingout.recordings.exports.dataset_card import CARD
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


@pytest.fixture
def of_one_name(five: MapSpec, tmp_path: Path) -> list[Path]:
    """Two different maps called Five, the first played twice, and a shipped one."""
    other = map_from_json(map_to_json(five) | {"goals": map_to_json(five)["goals"][:4]})
    played = {"a": five, "b": load_map("HandOff"), "c": other, "d": five}
    return [finalise(record(tmp_path, 3, episode_id=name, map=spec)[0]) for name, spec in played.items()]


def maps_in(name: str, target: Path) -> list[str]:
    """What an export calls the map of each of its episodes, in order."""
    if name == "csv":
        return [row["map"] for row in csv.DictReader((target / "episodes.csv").read_text().splitlines())]
    if name == "official":
        return [json.loads(row)["map_name"] for row in (target / "dataset.jsonl").read_text().splitlines()]
    if name == "lerobot":
        rows = pq.read_table(target / "meta" / "episodes", columns=["tasks", "seat"]).to_pylist()
        return [row["tasks"][0].partition(":")[0] for row in rows if row["seat"] == 0]
    return list(pq.read_table(target / "episodes.parquet")["map"].to_pylist())


@pytest.mark.parametrize(
    ("name", "title"), [("csv", "Five"), ("parquet", "Five"), ("official", "Five"), ("lerobot", "Practice Room")]
)
def test_different_maps_of_one_name_are_kept_apart_and_named(
    name: str, title: str, of_one_name: list[Path], tmp_path: Path
) -> None:
    told: list[str] = []
    target = tmp_path / "out"
    export(name, ExportPlan(of_one_name, target, tell=told.append))
    shipped = load_map("HandOff").title if name == "lerobot" else "HandOff"
    assert maps_in(name, target) == [f"{title}.1", shipped, f"{title}.2", f"{title}.1"]
    sentence = "2 different maps are called Five: Five.1 is that of a.mcap, Five.2 is that of c.mcap."
    assert told == [sentence]
    card = (target / CARD).read_text(encoding="utf-8")
    assert "| maps | Five.1 (2), Five.2 (1), HandOff (1) |" in card and f"**Maps.** {sentence}\n" in card


def test_a_robomimic_environment_is_of_one_of_the_maps_with_one_name(of_one_name: list[Path], tmp_path: Path) -> None:
    told: list[str] = []
    export("robomimic", ExportPlan(of_one_name, tmp_path / "x.hdf5", tell=told.append))
    with h5py.File(tmp_path / "x.hdf5") as file:
        assert json.loads(file["data"].attrs["env_args"])["env_kwargs"]["map"] == "Five.1"
    assert len(told) == 3 and "but 4 of 8 demos are of another map" in told[2]


def test_a_map_alone_with_its_name_keeps_it(of_one_name: list[Path], tmp_path: Path) -> None:
    told: list[str] = []
    export("csv", ExportPlan(of_one_name[:2] + of_one_name[3:], tmp_path / "out", tell=told.append))
    assert maps_in("csv", tmp_path / "out") == ["Five", "HandOff", "Five"] and told == []
    assert "**Maps.**" not in (tmp_path / "out" / CARD).read_text(encoding="utf-8")
