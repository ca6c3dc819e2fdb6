"""Loading maps by name, by path, and from official files."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.maps import MapError, MapSpec, library, load_map, map_names, map_to_json, shipped_map_names
from movingout.server.cli import main
from tests.support import reference

MODES = ("coordination", "awareness", "action consistency")


def geometry(spec: MapSpec) -> tuple[object, ...]:
    return spec.robots, spec.walls, spec.goals, spec.items


def test_the_twelve_maps_are_numbered_and_grouped_as_in_the_paper() -> None:
    maps = [load_map(name) for name in map_names()]
    assert [spec.number for spec in maps] == list(range(1, 13))
    assert [spec.name for spec in maps] == list(map_names())
    assert [spec.mode for spec in maps] == [mode for mode in MODES for _ in range(4)]
    assert all(spec.description and spec.title for spec in maps)


def test_the_practice_map_is_not_one_of_the_twelve() -> None:
    assert "Simple" not in map_names()
    assert (load_map("Simple").mode, load_map("Simple").number) == ("practice", 0)


def test_a_further_map_is_a_file_beside_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    further = map_to_json(load_map("HandOff")) | {"name": "WideHandOff", "number": 0}
    (tmp_path / "WideHandOff.json").write_text(json.dumps(further), encoding="utf-8")
    (tmp_path / "map.schema.json").write_text("{}", encoding="utf-8")
    monkeypatch.setattr(library, "_FOLDER", tmp_path)
    assert shipped_map_names() == (*map_names(), "WideHandOff", "Simple")
    assert load_map("WideHandOff").name == "WideHandOff"
    assert "WideHandOff" not in map_names()  # so that "all" stays the paper's


@pytest.mark.parametrize("name", (*map_names(), "Simple"))
def test_geometry_equals_the_official_map(name: str) -> None:
    ours = load_map(name)
    stem = f"{ours.number}_{name}" if ours.number else "simple"
    official = load_map(reference("maps") / f"{stem}.json")
    assert geometry(ours) == geometry(official)
    assert official.name == (name if ours.number else "simple")


def test_a_path_to_our_json_loads(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(map_to_json(load_map("LeftRight"))))
    assert load_map(path) == load_map(str(path)) == load_map("LeftRight")


def test_an_official_file_loads_without_its_number_in_the_name(tmp_path: Path) -> None:
    path = tmp_path / "7_My map.json"
    path.write_text(json.dumps(OFFICIAL))
    spec = load_map(path)
    assert (spec.name, spec.number) == ("My_map", 0)
    assert [item.id for item in spec.items] == [2, 10]
    assert len(spec.walls) == 1


def test_a_faulty_official_file_says_what_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "broken.json"
    path.write_text(json.dumps({key: value for key, value in OFFICIAL.items() if key != "target_areas"}))
    with pytest.raises(MapError, match=r"broken.json: not an official map file: KeyError 'target_areas'; needed are"):
        load_map(path)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("HandOf", r"unknown map 'HandOf'; did you mean HandOff\? known: HandOff, PassOrSplit"),
        ("fourcorners", r"did you mean FourCorners\?"),
        ("@maps.txt", "^'@maps.txt' names several maps; name each of them$"),
        ("all", "^'all' names several maps"),
        ("", "^unknown map ''; known: HandOff"),
        ("zzz", r"unknown map 'zzz'; known: HandOff.*, Simple, Tutorial$"),
        ("tutorail", r"did you mean Tutorial\?"),
        ("../secret", r"cannot read the map file ../secret: No such file"),
        ("absent.json", r"cannot read the map file absent.json: No such file"),
    ],
)
def test_an_unknown_map_is_answered_with_what_would_be_right(name: str, message: str) -> None:
    with pytest.raises(MapError, match=message):
        load_map(name)


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, '{"format": 1', "\x00"])
def test_a_file_that_is_no_json_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "broken.json"
    path.write_text(text)
    with pytest.raises(MapError, match=r"broken.json is not JSON"):
        load_map(path)


def test_a_name_that_stands_twice_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = json.dumps(map_to_json(load_map("Simple")))
    path = tmp_path / "mine.json"
    path.write_text(text.replace('"goals":', '"walls": [], "goals":', 1))
    with pytest.raises(MapError, match=r"mine.json: walls stands twice in one object"):
        load_map(path)
    assert main(["maps", "check", str(path)]) == 2
    assert "mine.json: walls stands twice in one object" in capsys.readouterr().err


def test_a_folder_or_binary_file_is_refused(tmp_path: Path) -> None:
    binary = tmp_path / "picture.json"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    for path in (tmp_path, binary):
        with pytest.raises(MapError, match=r"is a folder|not JSON"):
            load_map(path)


def test_a_fault_in_a_file_names_the_file_and_the_path(tmp_path: Path) -> None:
    document = map_to_json(load_map("Simple"))
    document["items"][1]["size"] = "huge"
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(document))
    with pytest.raises(MapError, match=r"mine.json: items\[1\].size: 'huge' is unknown; known: small, middle, large"):
        load_map(path)


OFFICIAL_ITEM = {"pos": [0, 0.5], "angle": 0.1, "shape": "circle", "size": "small", "mass": 0.1, "shape_scale": 0.06}
OFFICIAL = {
    "robot_1_pos": [0, 0],
    "robot_1_angle": 0,
    "robot_2_pos": [0.5, 0],
    "robot_2_angle": 1.57,
    "walls": [[[-1.2, 0.1], [-0.5, 0.2]], [None]],
    "target_areas": [[[0.8, 0.8], [1.2, 1.2]]],
    "items": {"10": OFFICIAL_ITEM, "2": OFFICIAL_ITEM, "3": None},
}


def test_a_map_whose_text_was_rewritten_is_the_same_map() -> None:
    spec = load_map("HandOff")
    rewritten = replace(spec, title="Übergabe", description="Ein enger Gang.")
    assert rewritten == spec and hash(rewritten) == hash(spec)
    assert replace(spec, number=2) != spec


def test_a_folder_is_no_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("maps").mkdir()
    for name in ("maps", "./maps", str(tmp_path / "maps")):
        with pytest.raises(MapError, match="is a folder; name the files in it, as "):
            load_map(name)
