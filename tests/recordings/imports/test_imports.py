"""Official trajectories come in as they are, and the report says how far they can be trusted."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from movingout.maps import load_map
from movingout.recordings import Episode, RecordingError, finalise, read_episode, verify
from movingout.recordings.imports.convert import ImportReport, import_source, pseudonym
from movingout.recordings.imports.sources import find, read
from movingout.recordings.official_format import dataset_row, recorder_steps
from movingout.server.cli import main
from tests.recordings.support import evaluator_steps, plain, record
from tests.support import reference

TICKS = 40
Json = dict[str, Any]


@pytest.fixture(scope="module")
def episode(tmp_path_factory: pytest.TempPathFactory) -> Episode:
    """A recording of ours with grabs: the fixtures are its official shapes."""
    journal, _ = record(tmp_path_factory.mktemp("ours"), ticks=TICKS, map_name="LeftRight", seed=3)
    return read_episode(finalise(journal))


def write(path: Path, document: object) -> Path:
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def imported(path: Path, folder: Path) -> tuple[ImportReport, Episode]:
    (source,) = read(path)
    report = import_source(source, folder, "salt")
    assert report.problem == ""
    return report, read_episode(folder / report.recording)


def assert_same_play(found: Episode, original: Episode, ticks: int) -> None:
    assert plain(found.states) == plain(original.states[: ticks + 1])
    assert np.array_equal(found.actions, original.actions[:ticks])
    assert [t.delivered for t in found.ticks] == [t.delivered for t in original.ticks[:ticks]]
    assert found.header.map == original.header.map


@pytest.fixture
def recorder(episode: Episode, tmp_path: Path) -> Path:
    return write(tmp_path / "LeftRight_20250101.json", [recorder_steps(episode)])


def test_the_recorders_json_comes_in_unchanged(recorder: Path, episode: Episode, tmp_path: Path) -> None:
    report, found = imported(recorder, tmp_path / "in")
    assert_same_play(found, episode, TICKS)
    assert (report.shape, report.ticks, report.drift, report.drift_tick) == ("recorder", TICKS, 0.0, -1)
    assert report.last_tick == "simulated"
    assert verify(tmp_path / "in" / report.recording).identical
    assert found.header.source == "import"


@pytest.mark.parametrize("suffix", [".jsonl", ".json", ".parquet"])
def test_data_set_rows_come_in_unchanged(suffix: str, episode: Episode, tmp_path: Path) -> None:
    row = dataset_row(episode, 5)
    path = tmp_path / f"rows{suffix}"
    if suffix == ".parquet":
        pq.write_table(pa.Table.from_pylist([row]), path)
    else:
        path.write_text(json.dumps([row] if suffix == ".json" else row), encoding="utf-8")
    report, found = imported(path, tmp_path / "in")
    assert_same_play(found, episode, TICKS)
    assert (report.shape, report.participants_known) == ("dataset", False)


def test_the_evaluators_json_holds_the_states_after_the_actions(episode: Episode, tmp_path: Path) -> None:
    path = write(tmp_path / "LeftRight.json", [evaluator_steps(episode)])
    report, found = imported(path, tmp_path / "in")
    assert_same_play(found, episode, TICKS)
    assert (report.shape, report.last_tick, report.drift_tick) == ("evaluator", "recorded", -1)
    assert [(seat.kind, seat.name) for seat in found.header.seats] == [("agent", "model_1"), ("agent", "model_2")]


def test_one_file_may_hold_many_episodes_and_a_folder_many_files(episode: Episode, tmp_path: Path) -> None:
    write(tmp_path / "two.json", [recorder_steps(episode), recorder_steps(episode)[:20]])
    write(tmp_path / "flat.json", recorder_steps(episode)[:10])
    sources = [source for file in find([tmp_path]) for source in read(file)]
    assert [(s.file.name, s.place) for s in sources] == [
        ("flat.json", "episode 0"),
        ("two.json", "episode 0"),
        ("two.json", "episode 1"),
    ]


def test_states_that_our_world_does_not_reproduce_are_kept_and_reported(
    recorder: Path, episode: Episode, tmp_path: Path
) -> None:
    ((*steps,),) = json.loads(recorder.read_text())
    for step in steps[20:]:
        step["states"]["items"][1]["pos"][0] += 0.25
    report, found = imported(write(recorder, [steps]), tmp_path / "in")
    assert report.drift == pytest.approx(0.25)
    assert report.drift_tick == 20
    assert (report.last_tick, report.ticks) == ("left out", TICKS - 1), "the state after the last action is unknown"
    expected = episode.states[30].item_poses[1, 0] + 0.25
    assert found.states[30].item_poses[1, 0] == expected
    divergence = verify(tmp_path / "in" / report.recording).first_divergence
    assert divergence is not None
    assert (divergence.tick, divergence.field) == (20, "item_poses[1, 0]")


def test_a_randomised_map_is_rebuilt_from_the_first_state(tmp_path: Path) -> None:
    designed = load_map("HandOff")
    items = (replace(designed.items[0], pose=replace(designed.items[0].pose, x=-1.0, y=1.0)), *designed.items[1:])
    journal, _ = record(tmp_path, ticks=12, map=replace(designed, items=items))
    original = read_episode(journal)
    path = write(tmp_path / "noise.json", [recorder_steps(original)])
    report, found = imported(path, tmp_path / "in")
    assert report.differences == ("pose of item 0",)
    assert (report.drift_tick, found.header.map.variant) == (-1, "imported")
    assert found.header.map.items == items
    assert plain(found.states) == plain(original.states)


def without(key: str) -> Callable[[Json], None]:
    def change(state: Json) -> None:
        for body in (*state["items"], state["robot_1"], state["robot_2"]):
            body.pop(key, None)

    return change


def renamed(old: str, new: str) -> Callable[[Json], None]:
    def change(state: Json) -> None:
        state[new] = state.pop(old)

    return change


@pytest.mark.parametrize(
    "change",
    [
        without("id"),
        without("shape_scale"),
        without("holded_item_id"),
        without("holded_item_pos"),
        without("holded_item_category"),
        lambda state: state.pop("target_color"),
        renamed("items", "debris"),
    ],
)
def test_keys_that_older_files_lack_are_not_needed(
    change: Callable[[Json], None], recorder: Path, episode: Episode, tmp_path: Path
) -> None:
    ((*steps,),) = json.loads(recorder.read_text())
    for step in steps:
        change(step["states"])
    report, found = imported(write(recorder, [steps]), tmp_path / "in")
    assert_same_play(found, episode, TICKS)
    assert report.differences == ()


def test_a_held_item_that_nobody_names_is_inferred_and_counted(
    recorder: Path, episode: Episode, tmp_path: Path
) -> None:
    ((*steps,),) = json.loads(recorder.read_text())
    for step in steps:
        for robot in ("robot_1", "robot_2"):
            del step["states"][robot]["holded_item_id"]
        for item in step["states"]["items"]:
            del item["hold"]
    report, found = imported(write(recorder, [steps]), tmp_path / "in")
    holds = sum(int((state.held >= 0).sum()) for state in episode.states[:-1])
    assert report.inferred_holds == holds
    assert [state.held.tolist() for state in found.states] == [state.held.tolist() for state in episode.states]


@pytest.mark.parametrize(("number", "name"), [(2004, "LeftRight"), ("2004", "LeftRight")])
def test_old_map_numbers_are_known(number: object, name: str, recorder: Path, tmp_path: Path) -> None:
    ((*steps,),) = json.loads(recorder.read_text())
    for step in steps:
        step["id"] = number
    report, _ = imported(write(recorder, [steps]), tmp_path / "in")
    assert report.map == name


def test_names_become_pseudonyms_that_only_the_salt_leads_back_from(
    recorder: Path, tmp_path: Path, all_bytes: Callable[[Path], bytes]
) -> None:
    ((*steps,),) = json.loads(recorder.read_text())
    for step in steps:
        step |= {"blue_name": "Grace Hopper", "red_name": "Ada Lovelace"}
    report, found = imported(write(recorder, [steps]), tmp_path / "in")
    assert [seat.name for seat in found.header.seats] == [
        pseudonym("Grace Hopper", "salt"),
        pseudonym("Ada Lovelace", "salt"),
    ]
    assert pseudonym("Grace Hopper", "salt") != pseudonym("Grace Hopper", "other")
    assert report.participants_known
    assert b"Hopper" not in all_bytes(tmp_path / "in")


def test_importing_twice_makes_no_copy(recorder: Path, tmp_path: Path) -> None:
    first, _ = imported(recorder, tmp_path / "in")
    second, _ = imported(recorder, tmp_path / "in")
    assert (first.unchanged, second.unchanged) == ("", "imported before; nothing changed")
    assert first == replace(second, unchanged="")
    assert len(list((tmp_path / "in").iterdir())) == 1


def test_the_report_counts_presses_and_what_they_did(recorder: Path, episode: Episode, tmp_path: Path) -> None:
    report, found = imported(recorder, tmp_path / "in")
    pressed = episode.actions[..., 2] > 0
    held = np.array([state.held for state in episode.states])
    changed = held[1:] != held[:-1]
    assert report.presses == pressed.sum()
    assert report.idle_presses == (pressed & ~changed).sum()
    assert report.unpressed_changes == 0
    assert report.largest_magnitude == np.abs(episode.actions[..., 0]).max()
    assert sum(event.kind in ("grab", "release") for event in found.events) >= changed.sum()


def test_real_official_trajectories_re_simulate_exactly(tmp_path: Path) -> None:
    """States of the official environment itself, written in its recorder's shape."""
    for name in ("HandOff_01", "AdaptiveAssist_06"):
        golden = dict(np.load(reference("golden") / f"{name}.npz"))
        path = write(tmp_path / f"{name}.json", [_official_steps(golden)])
        report, found = imported(path, tmp_path / "in")
        assert (report.drift_tick, report.differences) == (-1, ())
        assert len(found.ticks) == len(golden["actions"])
        assert np.array_equal([t.delivered for t in found.ticks], golden["delivered"][1:])


def _official_steps(golden: Any) -> list[Json]:
    spec = load_map(str(golden["map_name"]))
    return [
        {
            "id": spec.name,
            "step": step + 1,
            "states": {
                **{
                    f"robot_{seat + 1}": {
                        "pos": golden["robot_pos"][step, seat].tolist(),
                        "angle": float(golden["robot_angle"][step, seat]),
                        "hold": bool(golden["hold"][step, seat]),
                        "velocity": golden["robot_vel"][step, seat].tolist(),
                        "angular_velocity": float(golden["robot_angvel"][step, seat]),
                        "holded_item_id": int(golden["held_id"][step, seat]),
                    }
                    for seat in (0, 1)
                },
                "items": [
                    {
                        "pos": golden["item_pos"][step, index].tolist(),
                        "angle": float(golden["item_angle"][step, index]),
                        "shape": item.shape,
                        "size": item.size,
                        "shape_scale": item.scale,
                        "id": item.id,
                    }
                    for index, item in enumerate(spec.items)
                ],
                "target_area": [[[g.x0, g.y0], [g.x1, g.y1]] for g in spec.goals],
                "walls": [[[w.x0, w.y0], [w.x1, w.y1]] for w in spec.walls] or [[None]],
            },
            "action": golden["actions"][step].tolist(),
        }
        for step in range(len(golden["actions"]))
    ]


# ---- bad input ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda s: s[3]["states"].pop("robot_2"), "step 3: 'robot_2' is missing"),
        (lambda s: s[3]["states"].pop("items"), "step 3: no list of items"),
        (lambda s: s[2]["states"]["robot_1"].update(pos=[0.0]), "step 2 robot pos: 2 finite numbers are needed"),
        (lambda s: s[2]["states"]["robot_1"].update(angle=None), "step 2 robot: 1 finite number"),
        (lambda s: s[2].update(action=[[0, 0, 0]]), "step 2: two actions are needed"),
        (lambda s: s[2].update(action=[[0, float("nan"), 0]] * 2), "step 2: action: 3 finite numbers"),
        (lambda s: s[5]["states"]["items"].pop(), "the number of items changes"),
        (lambda s: s[0].update(id="Nowhere"), "unknown map 'Nowhere'; known: HandOff"),
        (lambda s: s[0]["states"]["items"][0].update(shape="banana"), "shape 'banana'"),
        (lambda s: s[0]["states"].update(walls=[[1, 2]]), "walls and target_area"),
        (lambda s: s[0]["states"].update(walls=[5]), "walls and target_area"),
        (lambda s: s[0]["states"].update(walls=5), "walls: a list is needed, not 5"),
        (lambda s: s[0]["states"].update(target_area=5), "target_area: a list is needed, not 5"),
        (lambda s: s[0]["states"].update(target_area=[[{}, {}]]), "walls and target_area"),
        (lambda s: s[0].update(id="²"), "unknown map '²'"),
        (lambda s: s[2]["states"]["robot_1"].update(pos=[10**400, 0]), "step 2 robot pos: 2 finite numbers"),
        (lambda s: s[0]["states"]["items"][0].update(id="abc"), "an item's id and shape_scale are numbers"),
        (lambda s: s[0]["states"]["items"][0].update(shape_scale=[1]), "an item's id and shape_scale are numbers"),
        (lambda s: s[0].update(red_name="\ud800"), "something in it is not as the official files have it"),
    ],
)
def test_a_fault_is_named_with_its_step_and_nothing_is_written(
    change: Callable[[list[Json]], object], sentence: str, recorder: Path, tmp_path: Path
) -> None:
    ((*steps,),) = json.loads(recorder.read_text())
    change(steps)
    (source,) = read(write(recorder, [steps]))
    report = import_source(source, tmp_path / "in", "salt")
    assert sentence in report.problem
    assert not (tmp_path / "in").exists()


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("x.json", b"{", "not JSON"),
        ("x.json", b"{}", "a list of episodes is needed"),
        ("x.json", b"[]", "a list of episodes is needed"),
        ("x.json", b"[[{}]]", "each step needs"),
        ("x.json", b"\xff\xfe", "not text"),
        ("x.jsonl", b'{"map_name": "HandOff"}', "row 0: 'map_name' and 'steps_data' are needed"),
        ("x.parquet", b"PAR1", "not a readable Parquet file"),
    ],
)
def test_files_of_another_kind_get_a_sentence(tmp_path: Path, name: str, content: bytes, sentence: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(RecordingError, match=sentence):
        read(tmp_path / name)


def test_an_odd_held_item_is_inferred_and_an_odd_time_is_that_of_the_file(recorder: Path, tmp_path: Path) -> None:
    """Both ended in a traceback: a list is no key, and a file has no time before 1970."""
    ((*steps,),) = json.loads(recorder.read_text())
    steps[0]["time"] = "1960-01-01_00:00:00"
    for step in steps:
        step["states"]["robot_1"]["holded_item_id"] = [1]
    path = write(recorder, [steps])
    assert imported(path, tmp_path / "in")[1].header.started_ns == path.stat().st_mtime_ns


def test_one_malformed_trajectory_does_not_stop_the_others(
    recorder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows: list[Json] = [{"map_name": name, "steps_data": "[[0, {}, []]]"} for name in ("²", "\ud800", "HandOff")]
    write(recorder.parent / "rows.json", rows)
    options = ["--out", str(tmp_path / "in"), "--workers", "1"]
    assert main(["recordings", "import", str(recorder.parent), *options]) == 1
    out = capsys.readouterr().out
    assert "1 of 4 trajectories imported" in out and out.count("refused: rows.json") == 3


def test_an_episode_without_a_step_does_not_stop_the_others(
    recorder: Path, episode: Episode, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(recorder, [[], recorder_steps(episode)])
    assert main(["recordings", "import", str(recorder), "--out", str(tmp_path / "in"), "--workers", "1"]) == 1
    out = capsys.readouterr().out
    assert "1 of 2 trajectories imported" in out and "episode 0: it has no step: nothing was played" in out


def test_the_command_imports_what_it_can_and_says_what_it_cannot(
    recorder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    row = {"map_name": "Nowhere", "trajectory_id": 0, "steps_data": "[]"}
    (recorder.parent / "rows.jsonl").write_text(json.dumps(row), encoding="utf-8")
    options = ["--out", str(tmp_path / "in"), "--workers", "1"]
    assert main(["recordings", "import", str(recorder.parent), *options, "--json"]) == 1
    reports = json.loads(capsys.readouterr().out)["trajectories"]
    assert [(r["file"], bool(r["problem"])) for r in reports] == [(recorder.name, False), ("rows.jsonl", True)]
    assert main(["demos", "import", str(recorder), *options]) == 0
    out = capsys.readouterr().out
    assert "0 of 1 trajectories imported" in out and "imported before; nothing changed" in out
    assert main(["recordings", "import", str(tmp_path / "nothing.txt"), *options]) == 2
    assert "is none of .json" in capsys.readouterr().err


def test_the_same_trajectory_twice_among_the_files_comes_in_once(
    recorder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (recorder.parent / "copy.json").write_bytes(recorder.read_bytes())
    options = ["--out", str(tmp_path / "out"), "--workers", "2"]
    assert main(["recordings", "import", str(recorder.parent), *options]) == 0
    out = capsys.readouterr().out
    assert "1 of 1 trajectories imported" in out
    assert "copies: 1 more" in out
