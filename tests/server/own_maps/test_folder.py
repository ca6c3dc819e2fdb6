"""The operator's own maps: a folder of files, some of them broken, some changing."""

import asyncio
import json
import os
from pathlib import Path
from typing import Any

import pytest

from movingout.maps import MapError, load_map, map_to_json
from movingout.server.own_maps.folder import MAX_BYTES, MAX_FILES, FolderError, MapFolder, Outcome, read_map_file


def document(name: str = "Garage", **changes: object) -> dict[str, Any]:
    return map_to_json(load_map("Simple")) | {"name": name, **changes}


def put(folder: Path, file: str, content: object) -> Path:
    path = folder / file
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


def read(folder: Path) -> MapFolder:
    maps = MapFolder(folder)
    maps.read()
    return maps


async def now(path: Path) -> Outcome:
    return read_map_file(path)


def test_without_a_folder_there_are_none() -> None:
    maps = MapFolder(None)
    maps.read()
    asyncio.run(maps.refresh(now))
    assert (maps.maps, maps.problems, maps.find("Garage")) == ({}, {}, None)


def test_the_good_files_are_offered_and_each_broken_one_has_a_sentence(tmp_path: Path) -> None:
    put(tmp_path, "garage.json", document())
    put(tmp_path, "half.json", '{"format": 1')
    put(tmp_path, "huge.json", " " * (MAX_BYTES + 1))
    put(tmp_path, "shape.json", document("Shape", goals=[]))
    put(tmp_path, "wall.json", document("Wall", walls=[{"x0": -1.2, "y0": -1.2, "x1": 1.2, "y1": 1.2}]))
    put(tmp_path, "notes.txt", "no map")
    (tmp_path / "folder.json").mkdir()
    maps = read(tmp_path)
    assert list(maps.maps) == ["Garage"]
    assert maps.problems["half.json"].startswith("half.json is not JSON")
    assert maps.problems["huge.json"] == "huge.json is larger than 64 KiB, which no map is"
    assert maps.problems["shape.json"] == "shape.json: goals: 1 to 64 entries are allowed, not 0"
    assert maps.problems["wall.json"].startswith("wall.json: robots.blue: stands in walls[0]")
    assert maps.problems["wall.json"].endswith("more; movingout maps check lists them)")
    assert maps.problems["folder.json"] == "folder.json is no plain file"
    assert len(maps.problems) == 5


def test_no_link_is_followed_and_no_pipe_waited_for(tmp_path: Path) -> None:
    inside, outside = tmp_path / "inside", tmp_path / "outside"
    inside.mkdir()
    outside.mkdir()
    secret = put(outside, "secret.json", document("Secret"))
    (inside / "link.json").symlink_to(secret)
    os.mkfifo(inside / "pipe.json")
    maps = read(inside)
    assert maps.maps == {}
    assert maps.problems["link.json"].startswith("link.json cannot be read: ")
    assert maps.problems["pipe.json"] == "pipe.json is no plain file"


def test_names_with_odd_signs_are_shown_safely(tmp_path: Path) -> None:
    put(tmp_path, "a\nb\x1b[31m.json", "{")
    os.close(os.open(os.fsencode(tmp_path) + b"/\xff.json", os.O_CREAT | os.O_WRONLY))
    put(tmp_path, "großer Raum <b>.json", document("GrosserRaum", title="<b>ü</b>"))
    maps = read(tmp_path)
    assert maps.maps["GrosserRaum"].title == "<b>ü</b>"
    assert all(sentence.isprintable() and sentence.encode() for sentence in maps.problems.values())
    assert len(maps.problems) == 2


def test_a_shipped_name_and_a_name_that_is_taken_are_left_out(tmp_path: Path) -> None:
    put(tmp_path, "a.json", document())
    put(tmp_path, "b.json", document())
    put(tmp_path, "c.json", map_to_json(load_map("HandOff")))
    put(tmp_path, "d.json", document("HandOff"))
    put(tmp_path, "e.json", document("HandOff:mirror"))
    for name in ("generated", "generated:awareness:0:easy"):
        put(tmp_path, f"{name}.json", document(name))
    maps = read(tmp_path)
    assert list(maps.maps) == ["Garage"]
    assert maps.problems == {
        "b.json": "b.json: a.json has the name Garage already; change one",
        "c.json": "c.json: this is the shipped map HandOff, which is offered anyway",
        "d.json": "d.json: HandOff is the name of a shipped map; give this one another name",
        "e.json": "e.json: HandOff:mirror is the name of a shipped map; give this one another name",
        **{
            f"{name}.json": f"{name}.json: {name} names maps of the generator; give this one another name"
            for name in ("generated", "generated:awareness:0:easy")
        },
    }


def test_a_map_of_the_folder_has_symmetries(tmp_path: Path) -> None:
    put(tmp_path, "garage.json", document())
    found = read(tmp_path).find("Garage:mirror:rot90")
    assert found is not None and found.name == "Garage:mirror:rot90"
    assert read(tmp_path).find("Garage:tilted") is read(tmp_path).find("../garage") is None


def test_an_official_file_is_offered(tmp_path: Path) -> None:
    spec = load_map("Simple")
    item = {"pos": [0, 0.5], "angle": 0, "shape": "circle", "size": "small", "mass": 0.1, "shape_scale": 0.06}
    blue, red = spec.robots
    put(tmp_path, "14_My Room.json", {
        "robot_1_pos": [blue.x, blue.y], "robot_1_angle": 0, "robot_2_pos": [red.x, red.y], "robot_2_angle": 0,
        "walls": [[None]], "target_areas": [[[-1.2, 1.2], [-0.6, 0.6]]], "items": {"0": item},
    })  # fmt: skip
    assert list(read(tmp_path).maps) == ["My_Room"]


def test_what_is_added_changed_and_removed_is_noticed_without_reading_the_rest_again(tmp_path: Path) -> None:
    put(tmp_path, "garage.json", document())
    put(tmp_path, "shed.json", document("Shed"))
    moment = [0.0]
    maps = MapFolder(tmp_path, lambda: moment[0])
    maps.read()
    opened: list[str] = []

    async def counted(path: Path) -> Outcome:
        opened.append(path.name)
        return read_map_file(path)

    def look() -> list[str]:
        moment[0] += 2.0
        opened.clear()
        asyncio.run(maps.refresh(counted))
        return sorted(maps.maps)

    assert (look(), opened) == (["Garage", "Shed"], [])
    put(tmp_path, "attic.json", document("Attic"))
    put(tmp_path, "shed.json", document("Shed", title="A longer title"))
    assert (look(), opened) == (["Attic", "Garage", "Shed"], ["attic.json", "shed.json"])
    assert maps.maps["Shed"].title == "A longer title"
    put(tmp_path, "shed.json", "{ broken")
    assert look() == ["Attic", "Garage"] and "shed.json" in maps.problems
    (tmp_path / "shed.json").unlink()
    (tmp_path / "garage.json").unlink()
    assert look() == ["Attic"] and maps.problems == {}
    moment[0] += 0.1
    put(tmp_path, "loft.json", document("Loft"))
    asyncio.run(maps.refresh(counted))
    assert list(maps.maps) == ["Attic"], "not looked at again within a second"


def test_a_folder_that_vanishes_while_serving_keeps_its_maps(tmp_path: Path) -> None:
    folder = tmp_path / "maps"
    folder.mkdir()
    put(folder, "garage.json", document())
    moment = [0.0]
    maps = MapFolder(folder, lambda: moment[0])
    maps.read()
    folder.rename(tmp_path / "gone")
    moment[0] = 5.0
    asyncio.run(maps.refresh(now))
    assert list(maps.maps) == ["Garage"]


def test_more_files_than_can_be_offered_are_said(tmp_path: Path) -> None:
    for number in range(MAX_FILES + 1):
        put(tmp_path, f"{number:03}.json", "{")
    maps = read(tmp_path)
    assert f"only the first {MAX_FILES}" in maps.problems[""]


@pytest.mark.parametrize("path", ["absent", "file.json"])
def test_a_folder_that_is_none_is_told(tmp_path: Path, path: str) -> None:
    put(tmp_path, "file.json", document())
    with pytest.raises(FolderError, match="cannot read the folder of maps"):
        read(tmp_path / path)
    assert issubclass(FolderError, MapError)
