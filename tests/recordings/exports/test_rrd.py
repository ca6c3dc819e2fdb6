"""The export for the Rerun viewer, read back by Rerun itself."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from movingout.recordings import RecordingError, finalise, read_episode
from movingout.recordings.exports import export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.rrd import TRAIL_TICKS, trail
from tests.recordings.full_disk import limited
from tests.recordings.support import record

ENTITIES = {
    "/arena", "/arena/floor", "/arena/goals", "/arena/walls", "/arena/blue", "/arena/red/body", "/arena/red/name",
    "/arena/items/0", "/arena/trails/blue", "/arena/trails/red", "/metrics/tcr", "/metrics/nfd", "/metrics/wt_s",
    "/actions/blue/distance", "/actions/red/grasp", "/log",
}  # fmt: skip


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("recordings")
    return [finalise(record(folder, ticks=6, episode_id=name)[0]) for name in ("first", "second")]


def rerun(home: Path, *arguments: str) -> str:
    command = [sys.executable, "-P", "-m", "rerun", *arguments]
    done = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, "HOME": str(home)}, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


def test_rerun_verifies_the_file_and_finds_every_entity(recordings: list[Path], tmp_path: Path) -> None:
    target = tmp_path / "first.rrd"
    export("rrd", ExportPlan(recordings[:1], target))
    assert "1 file verified without error" in rerun(tmp_path, "rrd", "verify", str(target))
    printed = rerun(tmp_path, "rrd", "print", str(target))
    assert {entity for entity in ENTITIES if entity not in printed} == set()
    assert "blueprint" in printed


def test_each_item_has_a_shape_and_moves_on_a_map_whose_ids_have_gaps(tmp_path: Path) -> None:
    """On AdaptiveAssist (ids 0, 1, 2, 4, 5, 7) two items stood still and others moved as another one did."""
    target = tmp_path / "gaps.rrd"
    export("rrd", ExportPlan([finalise(record(tmp_path, ticks=3, map_name="AdaptiveAssist")[0])], target))
    columns = set(
        re.findall(r"/arena/items/(\d+)@(Mesh3D|Transform3D):", rerun(tmp_path, "rrd", "print", "-v", str(target)))
    )
    assert columns == {(str(place), what) for place in range(6) for what in ("Mesh3D", "Transform3D")}


def test_several_recordings_become_a_folder(recordings: list[Path], tmp_path: Path) -> None:
    export("rrd", ExportPlan(recordings, tmp_path / "folder"))
    assert sorted(path.name for path in (tmp_path / "folder").iterdir()) == ["first.rrd", "second.rrd"]


@pytest.mark.parametrize(("name", "count"), [("one.rrd", 2), ("one.mcap", 1)])
def test_a_name_that_fits_no_export_is_refused(name: str, count: int, recordings: list[Path], tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"one recording becomes NAME.rrd, several a folder"):
        export("rrd", ExportPlan(recordings[:count], tmp_path / name))


def test_a_trail_goes_back_five_seconds_and_no_farther_than_the_start(tmp_path: Path) -> None:
    states = read_episode(finalise(record(tmp_path, ticks=TRAIL_TICKS + 5)[0])).states
    assert len(trail(states, 0, 0)) == 1
    assert len(trail(states, 0, 10)) == 11
    last = trail(states, 1, TRAIL_TICKS + 5)
    assert len(last) == TRAIL_TICKS + 1
    np.testing.assert_array_equal(last[-1, :2], states[-1].robot_poses[1, :2])


@pytest.mark.timeout(120)
@pytest.mark.parametrize("share", [0.001, 0.5, 0.98])
def test_a_full_disk_is_told_in_a_sentence_and_leaves_no_part(
    share: float, recordings: list[Path], tmp_path: Path
) -> None:
    """Rerun's own writer waited for ever on a disk that was full at once, and lost the end of a file in silence."""
    export("rrd", ExportPlan(recordings[:1], tmp_path / "whole.rrd"))
    size = (tmp_path / "whole.rrd").stat().st_size
    with limited(int(share * size)), pytest.raises(RecordingError, match=r"cannot write .*x\.rrd: File too large"):
        export("rrd", ExportPlan(recordings[:1], tmp_path / "x.rrd"))
    assert [path.name for path in tmp_path.iterdir()] == ["whole.rrd"]
