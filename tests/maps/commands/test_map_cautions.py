"""Map files that cannot be played, or that go by the name of a shipped map, are told of before anything is played."""

import json
from pathlib import Path
from typing import Any

import pytest

from movingout.maps import load_map, map_to_json
from movingout.maps.check import check_map, unreachable_goals
from movingout.maps.commands.map_cautions import map_cautions, map_hints
from movingout.maps.spec import WALL_MARGIN

_RED = {"x": 0.9, "y": 0.0, "angle": 0.0}
_ONE = map_to_json(load_map("HandOff"))["items"][:1]
_LOW = [_ONE[0] | {"x": 0.8, "y": -0.5}]
_UPPER = {"x0": -1.2, "y0": 1.2, "x1": 1.2, "y1": 0.6}


def _corridor(breadth: float) -> list[dict[str, float]]:
    """Walls across the arena, with a way of this breadth through them; the walls' margin is taken off."""
    right = 0.8 + breadth + 2 * WALL_MARGIN
    return [{"x0": -1.2, "y0": 0.5, "x1": 0.8, "y1": 0.2}, {"x0": right, "y0": 0.5, "x1": 1.2, "y1": 0.2}]


def _written(path: Path, **changes: Any) -> str:
    path.write_text(json.dumps(map_to_json(load_map("HandOff")) | changes))
    return str(path)


def test_maps_that_come_with_the_project_and_copies_of_them_need_no_caution(tmp_path: Path) -> None:
    generated = tmp_path / "generated.json"
    generated.write_text(json.dumps(map_to_json(load_map("generated:awareness:12"))))
    names = [
        "HandOff",
        "HandOff:mirror",
        "Tutorial",
        "generated:awareness:3",
        _written(tmp_path / "copy.json", title="Mine"),
    ]
    assert map_cautions([*names, f"{names[-1]}:rot90", str(generated)]) == []


def test_a_file_with_faults_is_told_once_with_its_first_faults(tmp_path: Path) -> None:
    tiny = [{"x0": -1.2, "y0": 1.2, "x1": -1.19, "y1": 1.19}]
    name = _written(tmp_path / "tiny.json", name="Tiny", number=0, goals=tiny)
    faults = [str(fault) for fault in check_map(load_map(name))]
    assert len(faults) > 3
    assert map_cautions([name, name]) == [
        f"{name} cannot be played as it should: {'; '.join(faults[:3])}; and {len(faults) - 3} more, see "
        "`movingout maps check`"
    ]


def test_another_map_under_the_name_of_a_shipped_one_would_be_taken_for_it(tmp_path: Path) -> None:
    items = map_to_json(load_map("HandOff"))["items"]
    name = _written(tmp_path / "mine.json", items=items[:2])
    assert map_cautions([name]) == [
        f"{name}: name: HandOff is a shipped map, and this is another one, which recordings, reports and training "
        "would take for that; choose another name"
    ]
    name = _written(tmp_path / "theirs.json", name="generated:awareness:12", number=0)
    (sentence,) = map_cautions([name])
    assert "name: generated:awareness:12 is the name of a generated map, and this is another one" in sentence


@pytest.mark.parametrize(
    ("changes", "hint"),
    [
        (
            {"name": "all", "number": 0},
            "name: all means the paper's twelve maps where maps are named; choose another name",
        ),
        (
            {"name": "generated", "number": 0},
            "name: generated means maps of the generator where maps are named; choose another name",
        ),
        (
            {"name": "Den", "number": 13},
            "number: numbers are those of the paper's maps; write 0 for a map of your own",
        ),
        (
            {"name": "Den:mirror", "number": 0},
            "name: Den:mirror means the map Den, mirrored or turned; choose a name without :",
        ),
        (
            {"name": "Den", "number": 0, "robots": {"blue": {"x": -0.9, "y": 0.0, "angle": -90}, "red": _RED}},
            "robots.blue.angle: angles are radians; if -90 degrees are meant, write -1.5708",
        ),
        (
            {"name": "Den", "number": 0, "robots": {"blue": {"x": -0.9, "y": 0.0, "angle": -720}, "red": _RED}},
            "robots.blue.angle: angles are radians; if -720 degrees are meant, write 0.0000",
        ),
        (
            {"name": "Den", "number": 0, "goals": [{"x0": -1.2, "y0": 1.2, "x1": 1.2, "y1": -1.2}], "items": _ONE},
            "items[0]: lies in a goal from the start and counts as delivered; move it out",
        ),
        (
            {"name": "Den", "number": 0, "items": [_ONE[0] | {"y": 0.601}], "goals": [_UPPER], "walls": []},
            "items[0]: sticks out of a goal with its centre in it: not delivered, and no way to go in NFD; move it",
        ),
        (
            {"name": "Den", "number": 0, "items": _ONE, "walls": [{"x0": 0.1, "y0": 0.5, "x1": 0.108, "y1": 0.2}]},
            "walls[0]: is too thin for NFD, whose ways lead through it; make it thicker than 0.02",
        ),
        (
            {"name": "Den", "number": 0, "items": _LOW, "goals": [_UPPER], "walls": _corridor(0.2)},
            "goals[0]: no robot can get to it, so that items could only be pushed in; widen a way to more than 0.24",
        ),
    ],
)
def test_what_probably_means_something_else_is_told(tmp_path: Path, changes: dict[str, Any], hint: str) -> None:
    name = _written(tmp_path / "den.json", **changes)
    assert [str(found) for found in map_hints(f"{name}:rot90")] == [hint]
    assert f"{name}: {hint}" in map_cautions([name])


def test_a_map_of_ones_own_after_a_symmetry_needs_no_hint(tmp_path: Path) -> None:
    assert map_hints(f"{_written(tmp_path / 'den.json', name='Den', number=0)}:mirror") == ()


@pytest.mark.parametrize(("breadth", "reached"), [(0.2, False), (0.3, True)])
def test_a_way_that_robots_fit_on_needs_no_hint_and_a_way_for_items_alone_can_be_played(
    breadth: float, reached: bool, tmp_path: Path
) -> None:
    """It passed as if robots could get to the green area."""
    name = _written(tmp_path / "den.json", name="Den", number=0, items=_LOW, goals=[_UPPER], walls=_corridor(breadth))
    assert check_map(load_map(name)) == ()
    assert (map_hints(name) == ()) is reached


def test_a_goal_in_the_middle_of_which_a_robot_is_shut_in_is_reached(tmp_path: Path) -> None:
    whole = [{"x0": -1.2, "y0": 1.2, "x1": 1.2, "y1": -1.2}]
    assert unreachable_goals(load_map(_written(tmp_path / "den.json", goals=whole))) == []
