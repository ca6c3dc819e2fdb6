import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from movingout.maps import ItemSpec, MapSpec, Pose, Rect, load_map, map_names, map_to_json
from movingout.maps.check import check_map, seats_at
from movingout.maps.document_check import check_document
from movingout.maps.spec import SHAPES
from tests.support import reference

OPEN = load_map("Simple")
GOAL = Rect(-1.2, 1.2, -0.6, 0.6)


def room(*items: ItemSpec, walls: tuple[Rect, ...] = (), goals: tuple[Rect, ...] = (GOAL,)) -> MapSpec:
    """An open room with the robots at the lower side and the goal in the upper left corner."""
    return replace(OPEN, items=items, walls=walls, goals=goals, robots=(Pose(-0.6, -1, 0), Pose(0.6, -1, 0)))


def item(x: float, y: float, size: str = "small", scale: float = 0.06, shape: str = "square") -> ItemSpec:
    return ItemSpec(0, shape, size, scale, 0.1, Pose(x, y, 0.3))  # type: ignore[arg-type]


def faults_of(spec: MapSpec) -> list[str]:
    return [str(fault) for fault in check_map(spec)]


@pytest.mark.parametrize("name", [*map_names(), "Simple"])
def test_shipped_maps_have_no_faults(name: str) -> None:
    assert faults_of(load_map(name)) == []


@pytest.mark.parametrize("text", ["\x1b[2J", "a\x00b", "\u202etxt.exe", "\u2066a", "\x9b31m"])
def test_texts_that_a_terminal_or_a_page_would_obey_are_named(text: str) -> None:
    found = check_map(replace(OPEN, title=text))
    assert [(fault.path, fault.code) for fault in found] == [("title", "control_characters")]
    assert [fault.path for fault in check_map(replace(OPEN, description=text))] == ["description"]


@pytest.mark.parametrize(
    "text", ["", "Two lines\nand a\ttab", "\u5730\u56f3 A \u2192 B", "\U0001f469\u200d\U0001f680", "\u05d1\u200f"]
)
def test_texts_may_have_lines_pictures_and_joiners(text: str) -> None:
    assert check_map(replace(OPEN, title=text, description=text)) == ()


def test_official_map_files_have_no_faults() -> None:
    for path in sorted(reference("maps").glob("*.json")):
        assert faults_of(load_map(path)) == [], path.name


def test_an_item_in_a_wall_is_named_with_the_wall() -> None:
    spec = room(item(0, 0), item(0.5, 0.53), walls=(Rect(0.8, 0.8, 0.9, 0.9), Rect(0.4, 0.4, 0.6, 0.5)))
    assert faults_of(spec) == ["items[1]: stands in walls[1]; walls are 0.01 thicker than drawn"]


def test_a_robot_in_a_wall_and_a_robot_on_an_item_are_named() -> None:
    spec = replace(room(item(0, 0), walls=(Rect(0.5, -0.5, 0.7, -0.4),)), robots=(Pose(0.1, 0, 0), Pose(0.6, -0.5, 0)))
    assert faults_of(spec) == [
        "robots.red: stands in walls[0]; walls are 0.01 thicker than drawn",
        "items[0]: overlaps robots.blue; move them apart",
    ]


def test_overlapping_robots_and_items_are_named_in_pairs() -> None:
    spec = replace(room(item(0, 0), item(0.05, 0.05)), robots=(Pose(-0.6, -1, 0), Pose(-0.5, -1, 0)))
    assert faults_of(spec) == [
        "robots.red: overlaps robots.blue; move them apart",
        "items[1]: overlaps items[0]; move them apart",
    ]


def test_what_sticks_out_of_the_arena_is_measured() -> None:
    spec = replace(room(item(0, 0)), robots=(Pose(-1.1, -1, 0), Pose(0.6, -1, 0)))
    assert faults_of(spec) == ["robots.blue: sticks 0.020 out of the arena; move it inwards (the sides are at 1.2)"]


def test_an_item_that_no_robot_can_get_to_is_named() -> None:
    walled_off = room(item(0.8, 0.8), walls=(Rect(0.4, 0.4, 0.45, 1.2), Rect(0.4, 0.4, 1.2, 0.45)))
    assert faults_of(walled_off) == [
        "items[0]: no robot can get to it; widen a way to more than 0.24",
        "items[0]: does not fit on any way to a goal: 0.11 broad, the way 0.00",
    ]


def test_a_large_item_needs_a_way_for_both_robots() -> None:
    apart = Rect(0.0, -1.2, 0.05, 1.2)
    small, large = item(-0.5, 0), item(-0.5, 0, "large", 0.17)
    assert faults_of(room(small, walls=(apart,))) == []
    assert seats_at(room(small, walls=(apart,)), small) == (True, False)
    message = "items[0]: is large, but red cannot get to it; widen the way to more than 0.24"
    assert faults_of(room(large, walls=(apart,))) == [message]


def test_an_item_too_broad_for_the_way_is_named_with_both_breadths() -> None:
    slit = (Rect(-1.2, 0.3, 0.0, 0.35), Rect(0.3, 0.3, 1.2, 0.35))
    assert faults_of(room(item(0, -0.3, "middle", 0.11), walls=slit)) == []
    [fault] = check_map(room(item(0, -0.3, "large", 0.17), walls=slit))
    assert fault.path == "items[0]"
    assert fault.message.startswith("does not fit on any way to a goal: 0.31 broad, the way 0.2")


def test_a_goal_too_small_for_one_item_or_for_all_together_is_named() -> None:
    tiny = (Rect(-0.1, 0.5, 0.1, 0.7),)
    big = item(0, -0.3, "large", 0.2)
    assert faults_of(room(big, goals=tiny)) == ["items[0]: is too big for every goal; enlarge one or shrink the item"]
    four = [replace(item(-0.9 + 0.6 * k, -0.3, "middle", 0.11), id=k) for k in range(4)]
    assert faults_of(room(*four, goals=tiny)) == [
        "goals: the goals are too small for all items together: items[1], items[2], items[3] found no place"
    ]


@pytest.mark.parametrize(
    ("goal", "walls"),
    [
        (Rect(0.3, 0.5, 0.301, 0.501), ()),
        (Rect(0.041, 0.541, 0.059, 0.559), ()),
        (Rect(0.3, 0.5, 0.4, 0.6), (Rect(0.3, 0.5, 0.4, 0.6),)),
    ],
)
def test_a_goal_that_no_distance_is_measured_to_is_a_fault(goal: Rect, walls: tuple[Rect, ...]) -> None:
    large = Rect(-0.5, 0.9, 0.5, 1.2)
    message = "goals[1]: is too small for distances to it; make it broader and higher than 0.02, out of walls"
    assert faults_of(room(item(0, -0.3), walls=walls, goals=(large, goal))) == [message]
    assert faults_of(room(item(0, -0.3), goals=(large, Rect(0.04, 0.54, 0.063, 0.563)))) == []


def broken(*changes: tuple[str, object]) -> dict[str, Any]:
    """The CornerDecision document with values replaced, or removed when the value is Ellipsis."""
    document: dict[str, Any] = json.loads(json.dumps(map_to_json(load_map("CornerDecision"))))
    for path, value in changes:
        *parents, last = [int(key) if key.isdigit() else key for key in path.split("/")]
        target: Any = document
        for key in parents:
            target = target[key]
        if value is ...:
            del target[last]
        else:
            target[last] = value
    return document


def test_every_unreadable_part_of_a_document_is_named_with_its_path() -> None:
    document = broken(
        ("items/1/shape", "blob"), ("items/3/size", "huge"), ("walls/1/x0", "left"), ("title", ...), ("robots/red/x", 9)
    )
    assert [str(fault) for fault in check_document(document)] == [
        "title: is missing",
        "robots.red.x: 9 is outside -1.2 to 1.2",
        "walls[1].x0: a number is needed here, not 'left'",
        f"items[1].shape: 'blob' is unknown; known: {', '.join(SHAPES)}",
        "items[3].size: 'huge' is unknown; known: small, middle, large",
    ]


def test_a_fault_between_entries_is_found_too() -> None:
    [fault] = check_document(broken(("items/1/id", 0)))
    assert (fault.path, fault.code) == ("items", "same_id")
    assert fault.message == "two items have the same id; give each its own"


@pytest.mark.parametrize("document", [None, 3, [], "map", {}, {"format": 1}])
def test_what_is_no_map_at_all_has_a_fault(document: object) -> None:
    assert check_document(document)


def test_a_document_that_can_be_read_is_checked_as_a_map() -> None:
    assert check_document(broken()) == ()
    assert [fault.path for fault in check_document(broken(("items/1/x", 0.0)))] == ["items[1]"]


def test_checking_changes_nothing(tmp_path: Path) -> None:
    document = broken(("items/1/shape", "blob"))
    before = json.dumps(document)
    check_document(document)
    assert json.dumps(document) == before
