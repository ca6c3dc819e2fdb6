"""Maps mirrored and turned: the group of the square, the geometry, the names."""

import itertools
import json
import math
from dataclasses import fields
from pathlib import Path

import pytest

from movingout.maps import MapError, Pose, is_shipped, load_map, map_from_json, map_to_json, shipped_map_names
from movingout.maps.check import check_map
from movingout.maps.spec import MapSpec
from movingout.maps.symmetry import ALL_SYMMETRIES, Symmetry, transformed

MIRROR = Symmetry(mirrored=True)
QUARTER = Symmetry(quarters=1)


def inverse(symmetry: Symmetry) -> Symmetry:
    """What brings everything back to where it was."""
    return next(other for other in ALL_SYMMETRIES if symmetry.then(other) == Symmetry())


def id_of(name: str, symmetry: Symmetry) -> str:
    return ":".join((name, *symmetry.names))


def test_a_mirrored_map_has_left_and_right_exchanged() -> None:
    plain, mirrored = load_map("HandOff"), load_map("HandOff:mirror")
    assert mirrored.name == "HandOff:mirror"
    assert [(wall.left, wall.right, wall.bottom, wall.top) for wall in mirrored.walls] == [
        (-wall.right, -wall.left, wall.bottom, wall.top) for wall in plain.walls
    ]
    assert [item.pose for item in mirrored.items] == [
        Pose(-item.pose.x, item.pose.y, -item.pose.angle) for item in plain.items
    ]
    assert mirrored.goals[0].left == -plain.goals[0].right


def test_a_quarter_turn_is_counter_clockwise_and_turns_the_robots() -> None:
    blue, red = load_map("HandOff:rot90").robots  # they stand at the centre and below it, and look up
    assert red == Pose(1.0, 0.0, math.pi / 2)
    assert blue == Pose(0.0, 0.0, math.pi / 2)
    assert math.copysign(1.0, blue.x) == 1.0, "no negative zero"


def test_symmetries_form_the_group_of_the_square() -> None:
    for one, other in itertools.product(ALL_SYMMETRIES, repeat=2):
        joined = one.then(other)
        assert joined in ALL_SYMMETRIES
        assert joined.point(0.3, 0.7) == other.point(*one.point(0.3, 0.7))
        assert joined.angle(0.4) == pytest.approx(other.angle(one.angle(0.4)), abs=1e-15)
    assert len({symmetry.point(0.3, 0.7) for symmetry in ALL_SYMMETRIES}) == 8
    assert {inverse(symmetry) for symmetry in ALL_SYMMETRIES} == set(ALL_SYMMETRIES)


@pytest.mark.parametrize("name", shipped_map_names())
def test_two_symmetries_in_a_name_are_one_and_back_is_the_map_to_the_last_bit(name: str) -> None:
    plain = load_map(name)
    for one, other in itertools.product(ALL_SYMMETRIES, repeat=2):
        assert load_map(f"{id_of(id_of(name, one), other)}") == load_map(id_of(name, one.then(other)))
    for symmetry in ALL_SYMMETRIES:
        assert load_map(id_of(id_of(name, symmetry), inverse(symmetry))) == plain
    assert transformed(transformed(plain, MIRROR), MIRROR) == plain


@pytest.mark.parametrize("name", shipped_map_names())
def test_a_map_that_is_moved_back_has_its_places_exactly_and_its_angles_to_rounding(name: str) -> None:
    plain = load_map(name)
    for symmetry in ALL_SYMMETRIES:
        back = transformed(transformed(plain, symmetry), inverse(symmetry))
        assert (back.name, back.walls, back.goals) == (plain.name, plain.walls, plain.goals)
        for there, here in zip((*back.robots, *(item.pose for item in back.items)),
                               (*plain.robots, *(item.pose for item in plain.items)), strict=True):  # fmt: skip
            assert (there.x, there.y) == (here.x, here.y)
            assert math.remainder(there.angle - here.angle, math.tau) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("name", ["HandOff", "SingleRotation", "FourCorners"])
def test_a_map_that_can_be_played_can_be_played_in_every_symmetry(name: str) -> None:
    for symmetry in ALL_SYMMETRIES:
        spec = load_map(id_of(name, symmetry))
        assert check_map(spec) == ()
        assert map_from_json(json.loads(json.dumps(map_to_json(spec)))) == spec


def test_a_file_has_symmetries_too(tmp_path: Path) -> None:
    path = tmp_path / "a:b.json"
    path.write_text(json.dumps(map_to_json(load_map("LeftRight")) | {"name": "Mine"}))
    assert load_map(f"{path}:mirror:rot180").name == "Mine:mirror:rot180"
    turned = tmp_path / "turned.json"
    turned.write_text(json.dumps(map_to_json(load_map(f"{path}:rot90"))))
    assert load_map(f"{turned}:rot270").name == "Mine"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("HandOff:mirored", "unknown symmetry 'mirored' of HandOff; did you mean mirror"),
        ("HandOff:", "unknown symmetry '' of HandOff; known: mirror, rot90, rot180, rot270"),
        ("HandOf:mirror", "unknown map 'HandOf'; did you mean HandOff"),
        ("absent.json:rot90", "cannot read the map file absent.json: No such file"),
        ("HandOff:45", "unknown symmetry '45'"),
    ],
)
def test_an_unknown_symmetry_is_answered_with_those_there_are(name: str, message: str) -> None:
    with pytest.raises(MapError) as refused:
        load_map(name)
    assert message in str(refused.value)


def test_an_unknown_symmetry_of_a_file_in_a_folder_is_no_missing_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(map_to_json(load_map("HandOff")) | {"name": "Mine"}))
    for name in (f"{path}:rot45", f"{path}:rot45:mirror"):
        with pytest.raises(MapError, match=r"unknown symmetry 'rot45' of \S*/mine\.json; did you mean rot90\?"):
            load_map(name)
    odd = path.rename(f"{path}:rot45")  # which a file may be called
    assert load_map(odd).name == "Mine"


def test_only_names_and_symmetries_of_shipped_maps_are_shipped(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text("{}")
    assert is_shipped("HandOff") and is_shipped("FourCorners:mirror:rot90")
    assert not any(map(is_shipped, ("", "Hand", "HandOff:x", "HandOff:", f"{path}", f"{path}:mirror", "../HandOff")))


def test_a_new_part_of_maps_is_not_left_behind() -> None:
    moved, kept = {"robots", "walls", "goals", "items"}, {"title", "number", "mode", "description", "variant"}
    assert {one.name for one in fields(MapSpec)} == {"name", *moved, *kept}, (
        "symmetries, variants, best rounds and exports leave out what they do not know: docs/architecture.md, "
        "“Where to change what”, names the places; then say here whether it is moved"
    )
    plain = load_map("HandOff")
    turned = transformed(plain, QUARTER)
    assert all(getattr(turned, part) != getattr(plain, part) for part in moved)
    assert all(getattr(turned, part) == getattr(plain, part) for part in kept)
