"""Every export is read back with the library that its users have."""

import csv
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import av
import h5py
import numpy as np
import pyarrow.parquet as pq
import pytest
from PIL import Image

from movingout.maps import load_map
from movingout.maps.extras import MissingExtraError
from movingout.recordings import Episode, RecordingError, SeatInfo, finalise, read_episode
from movingout.recordings.exports import FORMATS, export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import SplitBy
from movingout.recordings.exports.tables import TABLES
from movingout.world.action import to_policy, to_world
from movingout.world.metrics import EpisodeMetrics
from movingout.world.observation import LAYOUTS, encode_state
from tests.recordings.support import record

TICKS = 14


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two episodes of different people on different maps."""
    folder = tmp_path_factory.mktemp("recordings")
    other = (SeatInfo("human", "P-9", device="keyboard"), SeatInfo("human", "P-10", device="touch"))
    first, _ = record(folder, ticks=TICKS, episode_id="first", map_name="AdaptiveAssist")
    second, _ = record(folder, ticks=9, episode_id="second", map_name="LeftRight", seats=other)
    return [finalise(first), finalise(second)]


@pytest.fixture(scope="module")
def episode(recordings: list[Path]) -> Episode:
    return read_episode(recordings[0])


def made(name: str, recordings: list[Path], target: Path, **options: Any) -> Path:
    export(name, ExportPlan(recordings, target, **options))
    return target


# ---- tables ------------------------------------------------------------------------------------------------


def test_parquet_ticks_hold_the_states_the_actions_and_what_each_seat_saw(
    recordings: list[Path], episode: Episode, tmp_path: Path
) -> None:
    folder = made("parquet", recordings, tmp_path / "tables")
    rows = [row for row in pq.read_table(folder / "ticks.parquet").to_pylist() if row["episode_id"] == "first"]
    assert [row["tick"] for row in rows] == list(range(TICKS + 1))
    for row, state in zip(rows, episode.states, strict=True):
        assert [row["red_x"], row["red_y"], row["red_angle"]] == state.robot_poses[1].tolist()
        assert [row["item_3_x"], row["item_3_y"], row["item_3_angle"]] == state.item_poses[3].tolist()
        assert (row["blue_held"], row["red_held"]) == tuple(state.held.tolist())
        seen = encode_state(episode.header.map, state, 1).astype(np.float32)
        assert np.array_equal(np.array(row["red_observation"], dtype=np.float32), seen)
    for row, tick in zip(rows[1:], episode.ticks, strict=True):
        assert [row["blue_distance"], row["blue_heading"], row["blue_grasp"]] == tick.actions[0].tolist()
        assert row["late_ms"] == tick.late_ms
    assert (rows[0]["blue_distance"], rows[0]["late_ms"], rows[0]["item_6_x"]) == (None, None, None)


def test_parquet_episodes_and_events_join_by_episode_id(recordings: list[Path], tmp_path: Path) -> None:
    folder = made("parquet", recordings, tmp_path / "tables")
    episodes = pq.read_table(folder / "episodes.parquet").to_pylist()
    assert [(e["episode_id"], e["map"], e["ticks"], e["blue_name"]) for e in episodes] == [
        ("first", "AdaptiveAssist", TICKS, "P-3f2a"),
        ("second", "LeftRight", 9, "P-9"),
    ]
    events = pq.read_table(folder / "events.parquet").to_pylist()
    assert [(e["episode_id"], e["tick"], e["kind"], e["seat"]) for e in events] == [
        ("first", 5, "grab", "blue"),
        ("first", 10, "grab", "blue"),
        ("second", 5, "grab", "blue"),
    ]


def test_running_metrics_of_the_last_row_are_those_of_the_episode(
    recordings: list[Path], episode: Episode, tmp_path: Path
) -> None:
    folder = made("parquet", recordings[:1], tmp_path / "tables")
    last = pq.read_table(folder / "ticks.parquet").to_pylist()[-1]
    metrics = EpisodeMetrics(episode.header.map)
    metrics.update_episode(list(episode.states), episode.actions)
    expected = metrics.result().values()
    assert {key: last[key] for key in expected} == expected


def test_csv_holds_the_same_numbers_to_the_last_digit(recordings: list[Path], episode: Episode, tmp_path: Path) -> None:
    folder = made("csv", recordings, tmp_path / "tables")
    with (folder / "ticks.csv").open(newline="", encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if row["episode_id"] == "first"]
    for row, state in zip(rows, episode.states, strict=True):
        assert [float(row["blue_x"]), float(row["blue_y"])] == state.robot_poses[0, :2].tolist()
    assert rows[0]["blue_distance"] == ""


@pytest.mark.parametrize("name", ["parquet", "csv"])
def test_the_data_dictionary_names_every_column(name: str, recordings: list[Path], tmp_path: Path) -> None:
    folder = made(name, recordings, tmp_path / "tables")
    page = (folder / "DATA_DICTIONARY.md").read_text(encoding="utf-8")
    for table, columns in TABLES.items():
        assert f"## {table}" in page
        for column in columns:
            assert f"| `{column.name}` | {column.type} |" in page


@pytest.mark.parametrize(
    ("by", "meaning"),
    [
        ("participant", "no participant is in both; who played outside a study has a name person-… per room"),
        ("episode", "a participant may be in both"),
        ("map", "no map is in both, a participant may be"),
    ],
)
def test_the_tables_say_what_their_split_keeps_apart(
    by: SplitBy, meaning: str, recordings: list[Path], tmp_path: Path
) -> None:
    """They promised that no participant is in both parts, however these were divided."""
    for name in ("csv", "parquet"):
        folder = made(name, recordings, tmp_path / name, split_by=by)
        page = (folder / "DATA_DICTIONARY.md").read_text(encoding="utf-8")
        assert f"| `split` | string |  | train or test; {meaning} |" in page
    field = pq.read_schema(tmp_path / "parquet" / "episodes.parquet").field("split")
    assert field.metadata[b"meaning"].decode() == f"train or test; {meaning}"


# ---- training formats --------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore:env_args name AdaptiveAssist")
def test_robomimic_demos_pair_what_was_seen_with_what_was_done(
    recordings: list[Path], episode: Episode, tmp_path: Path
) -> None:
    path = made("robomimic", recordings, tmp_path / "demos.hdf5", test_share=0.5)
    with h5py.File(path) as file:
        demos = {name: dict(group.attrs) for name, group in file["data"].items()}
        assert [(d["recording"], d["seat"], d["num_samples"]) for d in demos.values()] == [
            ("first", 0, TICKS),
            ("first", 1, TICKS),
            ("second", 0, 9),
            ("second", 1, 9),
        ]
        assert file["data"].attrs["total"] == 2 * TICKS + 18
        red = file["data/demo_1"]
        expected = to_policy(episode.actions)[:, 1].astype(np.float32)
        assert np.array_equal(red["actions"][:], expected)
        seen = [encode_state(episode.header.map, state, 1) for state in episode.states]
        assert np.array_equal(red["obs/flat"][:], np.array(seen[:-1], dtype=np.float32))
        assert np.array_equal(red["next_obs/flat"][:], np.array(seen[1:], dtype=np.float32))
        masks = {name: {demo.decode() for demo in file[f"mask/{name}"]} for name in ("train", "valid")}
    assert masks["train"] | masks["valid"] == set(demos)
    assert masks["valid"] in ({"demo_0", "demo_1"}, {"demo_2", "demo_3"}), "both seats of an episode go together"
    np.testing.assert_allclose(to_world(expected)[:, 0], episode.actions[:, 1, 0], atol=1e-6)


@pytest.mark.parametrize("layout", [name for name, layout in LAYOUTS.items() if not layout.picture])
def test_every_layout_of_numbers_can_be_exported(
    recordings: list[Path], episode: Episode, tmp_path: Path, layout: str
) -> None:
    path = made("robomimic", recordings[:1], tmp_path / "demos.hdf5", layout=layout)
    expected = [encode_state(episode.header.map, state, 1, layout) for state in episode.states[:-1]]
    with h5py.File(path) as file:
        assert np.array_equal(file["data/demo_1/obs/flat"][:], np.array(expected, dtype=np.float32))


def test_lerobot_has_the_files_and_features_that_its_loader_wants(recordings: list[Path], tmp_path: Path) -> None:
    folder = made("lerobot", recordings, tmp_path / "dataset", test_share=0.5)
    info = json.loads((folder / "meta" / "info.json").read_text())
    assert (info["codebase_version"], info["fps"], info["total_episodes"]) == ("v3.0", 10, 4)
    data = pq.read_table(folder / "data" / "chunk-000" / "file-000.parquet")
    assert set(data.column_names) == set(info["features"])
    assert data.num_rows == info["total_frames"] == 2 * TICKS + 18
    hints = json.loads(data.schema.metadata[b"huggingface"])["info"]["features"]
    for name, feature in info["features"].items():
        assert hints[name].get("length", 1) == feature["shape"][0]
    assert data["index"].to_pylist() == list(range(data.num_rows))
    stats = json.loads((folder / "meta" / "stats.json").read_text())
    actions = np.array(data["action"].to_pylist())
    np.testing.assert_allclose(stats["action"]["mean"], actions.mean(axis=0), rtol=1e-6)
    assert stats["action"]["count"] == [data.num_rows]


def test_lerobot_episodes_cover_the_frames_training_first(recordings: list[Path], tmp_path: Path) -> None:
    folder = made("lerobot", recordings, tmp_path / "dataset", test_share=0.5)
    info = json.loads((folder / "meta" / "info.json").read_text())
    assert info["splits"] == {"train": "0:2", "test": "2:4"}
    episodes = pq.read_table(folder / "meta" / "episodes" / "chunk-000" / "file-000.parquet").to_pylist()
    ends = [0, *(episode["dataset_to_index"] for episode in episodes)]
    assert [episode["dataset_from_index"] for episode in episodes] == ends[:-1]
    assert ends[-1] == info["total_frames"]
    tasks = pq.read_table(folder / "meta" / "tasks.parquet")
    assert json.loads(tasks.schema.metadata[b"pandas"])["index_columns"] == ["__index_level_0__"]
    assert {episode["tasks"][0] for episode in episodes} == set(tasks["__index_level_0__"].to_pylist())


def test_the_joint_view_has_one_episode_with_both_actions(
    recordings: list[Path], episode: Episode, tmp_path: Path
) -> None:
    folder = made("lerobot", recordings[:1], tmp_path / "dataset", view="joint", layout="map-v1")
    info = json.loads((folder / "meta" / "info.json").read_text())
    assert info["features"]["action"]["names"][4] == "red_distance"
    assert info["features"]["observation.state"]["shape"] == [16]
    assert info["features"]["observation.environment_state"]["shape"] == [169 - 16]
    assert info["movingout"] == {"layout": "map-v1", "view": "joint", "headings": "arena"}
    data = pq.read_table(folder / "data" / "chunk-000" / "file-000.parquet")
    expected = to_policy(episode.actions).reshape(TICKS, 8).astype(np.float32)
    assert np.array_equal(np.array(data["action"].to_pylist(), dtype=np.float32), expected)


# ---- official JSON -----------------------------------------------------------------------------------------


def test_the_official_recorder_file_has_the_official_layout_field_by_field(
    recordings: list[Path], episode: Episode, tmp_path: Path
) -> None:
    folder = made("official", recordings, tmp_path / "official")
    ((*steps,),) = json.loads((folder / "recorder" / "AdaptiveAssist_first.json").read_text())
    assert len(steps) == TICKS
    first = steps[0]
    assert list(first) == [
        *("red_name", "blue_name", "time", "id", "step", "states", "rew", "done", "action", "test_mode")
    ]
    assert (first["id"], first["step"], first["blue_name"]) == ("AdaptiveAssist", 1, "P-3f2a")
    states = first["states"]
    assert list(states) == ["robot_1", "robot_2", "items", "target_area", "target_color", "walls"]
    robot = ["pos", "angle", "hold", "velocity", "angular_velocity"]
    assert list(states["robot_1"]) == [*robot, "holded_item_id", "holded_item_pos", "holded_item_category"]
    item = ["pos", "angle", "shape", "size", "shape_scale", "color", "id", "hold"]
    assert all(list(entry) == item for entry in states["items"])
    assert [entry["id"] for entry in states["items"]] == [0, 1, 2, 4, 5, 7], "official ids, gaps kept"
    spec = load_map("AdaptiveAssist")
    assert states["walls"] == [[[wall.x0, wall.y0], [wall.x1, wall.y1]] for wall in spec.walls]
    assert states["target_area"] == [[[goal.x0, goal.y0], [goal.x1, goal.y1]] for goal in spec.goals]


def test_official_states_are_those_before_the_action(recordings: list[Path], episode: Episode, tmp_path: Path) -> None:
    folder = made("official", recordings, tmp_path / "official")
    rows = [json.loads(line) for line in (folder / "dataset.jsonl").read_text().splitlines()]
    assert [(row["map_name"], row["trajectory_id"]) for row in rows] == [("AdaptiveAssist", 0), ("LeftRight", 0)]
    for (number, states, actions), state, tick in zip(
        json.loads(rows[0]["steps_data"]), episode.states, episode.ticks, strict=False
    ):
        assert number == state.tick
        assert [*states["robot_2"]["pos"], states["robot_2"]["angle"]] == state.robot_poses[1].tolist()
        assert states["robot_1"]["hold"] == (state.held[0] >= 0)
        assert actions == [[*row[:2], bool(row[2])] for row in tick.actions.tolist()]


# ---- pictures ----------------------------------------------------------------------------------------------


def test_an_mp4_plays_as_long_as_the_episode_or_n_times_shorter(recordings: list[Path], tmp_path: Path) -> None:
    lengths = {}
    for speed in (1.0, 2.0):
        path = made("mp4", recordings[:1], tmp_path / f"{speed}.mp4", side=128, speed=speed)
        with av.open(str(path)) as container:
            (stream,) = container.streams.video
            frames = list(container.decode(stream))
            lengths[speed] = len(frames) / float(stream.average_rate or 0)
        assert (frames[0].width, frames[0].height) == (128, 138)
    start_and_end = 0.08  # two pictures more
    assert lengths == {speed: pytest.approx(TICKS / 10 / speed, abs=start_and_end) for speed in (1.0, 2.0)}


def test_a_gif_has_a_picture_per_tick(recordings: list[Path], tmp_path: Path) -> None:
    path = made("gif", recordings[:1], tmp_path / "x.gif", side=96, overlay=False)
    with Image.open(path) as picture:
        assert picture.size == (96, 96)
        assert picture.info["duration"] == 100
        assert getattr(picture, "n_frames", 1) > TICKS / 2  # equal neighbours are merged by Pillow


def test_a_strip_shows_start_steps_and_end_side_by_side(recordings: list[Path], tmp_path: Path) -> None:
    path = made("png", recordings[:1], tmp_path / "x.png", side=96, every_s=0.5, overlay=False)
    with Image.open(path) as strip:
        assert strip.size == (4 * 96 + 3 * 2, 96), "at 0.0, 0.5, 1.0 and 1.4 s, 2 pixels between them"


def test_several_recordings_become_a_folder_of_pictures(recordings: list[Path], tmp_path: Path) -> None:
    folder = made("png", recordings, tmp_path / "strips", side=64, every_s=10.0)
    assert sorted(path.name for path in folder.iterdir()) == ["first.png", "second.png"]


# ---- every format ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FORMATS)
def test_an_interrupted_export_leaves_nothing_behind(
    name: str, recordings: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(recordings[1].read_bytes()[:-100])
    plan = ExportPlan([recordings[0], broken], tmp_path / "target", side=64)
    monkeypatch.setitem(plan.__dict__, "splits", ["train", "train"])
    with pytest.raises(RecordingError, match="incomplete"):
        export(name, plan)
    assert [path.name for path in tmp_path.iterdir()] == ["broken.mcap"]


@pytest.mark.parametrize("name", FORMATS)
def test_nothing_is_overwritten(name: str, recordings: list[Path], tmp_path: Path) -> None:
    (tmp_path / "target").write_text("mine")
    with pytest.raises(RecordingError, match="exists already"):
        made(name, recordings[:1], tmp_path / "target")
    assert (tmp_path / "target").read_text() == "mine"


@pytest.mark.parametrize("name", FORMATS)
def test_no_path_of_this_machine_gets_out(
    name: str, recordings: list[Path], tmp_path: Path, all_bytes: Callable[[Path], bytes]
) -> None:
    content = all_bytes(made(name, recordings[:1], tmp_path / "target", side=64))
    assert b"first" in content
    for path in (recordings[0].parent, tmp_path, Path.home()):
        assert str(path).encode() not in content


def test_a_missing_library_is_named_with_the_command_that_installs_it(
    recordings: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("robomimic", "hdf5_file"):
        monkeypatch.delitem(sys.modules, f"movingout.recordings.exports.{module}", raising=False)
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(
        MissingExtraError, match=r"robomimic \(h5py\) needs the extra `hdf5`.* -m pip install .*\[hdf5\]"
    ):
        made("robomimic", recordings, tmp_path / "x")


def test_wrong_requests_get_a_sentence(recordings: list[Path], tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"unknown format 'xls'; known: parquet, csv"):
        made("xls", recordings, tmp_path / "x")
    with pytest.raises(RecordingError, match="no recordings to export"):
        made("csv", [], tmp_path / "x")
    with pytest.raises(RecordingError, match=r"unknown view 'both'; known: ego, joint"):
        made("robomimic", recordings, tmp_path / "x", view="both")


@pytest.mark.parametrize(
    ("name", "target", "options", "sentence"),
    [
        ("mp4", "x", {"speed": float("nan")}, "--speed goes from 0.1 to 100"),
        ("png", "x", {"every_s": 0.0}, "--every from 0.1 to 3600 s"),
        ("gif", "x.png", {}, "one recording becomes NAME.gif, several a folder"),
        ("mp4", "x.mp4", {}, "one recording becomes NAME.mp4, several a folder"),
        ("robomimic", "x.json", {}, "a robomimic file ends in .hdf5"),
    ],
)
def test_a_target_or_number_that_fits_no_export_is_refused(
    name: str, target: str, options: dict[str, float], sentence: str, recordings: list[Path], tmp_path: Path
) -> None:
    with pytest.raises(RecordingError, match=sentence):
        made(name, recordings, tmp_path / target, **options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["csv", "png"])
def test_a_copy_or_a_torn_file_among_the_recordings_is_named(name: str, recordings: list[Path], tmp_path: Path) -> None:
    copy, torn = tmp_path / "copy.mcap", tmp_path / "torn.mcap"
    copy.write_bytes(recordings[0].read_bytes())
    torn.write_bytes(recordings[0].read_bytes()[:-100])
    with pytest.raises(RecordingError, match=r"first.mcap and copy.mcap are the same episode, first; leave one out"):
        made(name, [*recordings, copy], tmp_path / "x")
    with pytest.raises(RecordingError, match=r"torn.mcap is incomplete .*; leave it out to export the others"):
        made(name, [*recordings, torn], tmp_path / "x")
    assert not (tmp_path / "x").exists()
