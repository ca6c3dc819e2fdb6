"""The environment that a robomimic export names: what most of its demonstrations show."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import pytest

from movingout.maps import load_map, map_to_json
from movingout.maps.randomize import randomize
from movingout.recordings import RecordingError, finalise
from movingout.recordings.exports import export
from movingout.recordings.exports.plan import ExportPlan
from tests.recordings.support import record


def made(files: list[Path], folder: Path) -> Path:
    export("robomimic", ExportPlan(files, folder / "demos.hdf5"))
    return folder / "demos.hdf5"


def arguments_in(path: Path) -> dict[str, Any]:
    with h5py.File(path) as demos:
        found: dict[str, Any] = json.loads(demos["data"].attrs["env_args"])["env_kwargs"]
    return found


@pytest.mark.parametrize("name", ["generated:awareness:20000", "HandOff:mirror"])
def test_it_names_the_map_that_was_played(name: str, tmp_path: Path) -> None:
    """It named HandOff for generated maps."""
    file = finalise(record(tmp_path, ticks=3, map_name=name)[0])
    assert arguments_in(made([file], tmp_path))["map"] == name


def test_it_warns_of_a_map_of_ones_own(tmp_path: Path) -> None:
    own = tmp_path / "own.json"
    own.write_text(json.dumps(map_to_json(load_map("HandOff")) | {"name": "Own"}))
    file = finalise(record(tmp_path, ticks=3, map_name=str(own))[0])
    with pytest.warns(RuntimeWarning, match="env_args name Own, which is a map of your own: put the path of its file"):
        path = made([file], tmp_path)
    assert arguments_in(path)["map"] == "Own"


def test_it_names_a_map_of_ones_own_beside_another_that_was_played_less(tmp_path: Path) -> None:
    """Any map of the project won, even one without a tick."""
    own = replace(load_map("HandOff"), name="Own")
    played = (("a", 3, own), ("b", 3, own), ("c", 3, load_map("Simple")), ("d", 0, load_map("FourCorners")))
    files = [finalise(record(tmp_path, ticks=ticks, episode_id=name, map=one)[0]) for name, ticks, one in played]
    with pytest.warns(RuntimeWarning) as warned:
        path = made(files, tmp_path)
    assert arguments_in(path)["map"] == "Own"
    assert [str(one.message).split(",")[0] for one in warned] == ["env_args name Own", "env_args name Own as designed"]
    assert "2 of 6 demos are of another map" in str(warned[1].message)


def test_it_says_that_variants_were_played(tmp_path: Path) -> None:
    variant = randomize(load_map("HandOff"), 3, "evaluation")
    file = finalise(record(tmp_path, ticks=3, map=variant)[0])
    arguments = arguments_in(made([file], tmp_path))
    assert (arguments["map"], arguments["split"]) == ("HandOff", "evaluation")


def test_it_warns_of_variants_that_no_environment_draws(tmp_path: Path) -> None:
    file = finalise(record(tmp_path, ticks=3, map=replace(load_map("HandOff"), variant="imported"))[0])
    with pytest.warns(RuntimeWarning, match="env_args name HandOff as designed, but 2 of 2 demos are of another"):
        assert "split" not in arguments_in(made([file], tmp_path))


@pytest.mark.parametrize("variant", ["challenge2", "challenge2-", "challenge2-mine-3"])
def test_a_variant_of_ones_own_may_have_any_name(variant: str, tmp_path: Path) -> None:
    file = finalise(record(tmp_path, ticks=3, map=replace(load_map("Simple"), variant=variant))[0])
    with pytest.warns(RuntimeWarning, match="env_args name Simple as designed, but 2 of 2 demos are of another map"):
        assert "split" not in arguments_in(made([file], tmp_path))


def test_a_picture_is_refused_as_its_environment_gives_another_shape(tmp_path: Path) -> None:
    file = finalise(record(tmp_path, ticks=3)[0])
    with pytest.raises(RecordingError, match=r"image-v1 is a picture, .* take another --layout"):
        export("robomimic", ExportPlan([file], tmp_path / "demos.hdf5", layout="image-v1"))
    assert not (tmp_path / "demos.hdf5").exists()
