"""A trajectory whose start differs by a hair from the map as designed is an episode of Challenge 1."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from movingout.maps import load_map
from movingout.maps.spec import MapSpec
from movingout.recordings import finalise, read_episode, verify
from movingout.recordings.groups import is_varied
from movingout.recordings.imports import map_match
from movingout.recordings.imports.convert import ImportReport, import_source
from movingout.recordings.imports.map_match import is_as_designed
from movingout.recordings.imports.sources import read
from movingout.recordings.official_format import recorder_steps
from movingout.server.cli import main
from tests.recordings.support import plain, record

DESIGNED = load_map("HandOff")
FIRST = DESIGNED.items[0]


def moved(the_map: MapSpec, by: float) -> MapSpec:
    """The first item and the blue robot elsewhere."""
    item = replace(the_map.items[0], pose=replace(the_map.items[0].pose, x=the_map.items[0].pose.x + by))
    blue = replace(the_map.robots[0], angle=the_map.robots[0].angle + by)
    return replace(the_map, items=(item, *the_map.items[1:]), robots=(blue, the_map.robots[1]))


def file_of(tmp_path: Path, the_map: MapSpec, decimals: int = 99) -> tuple[Path, Any]:
    """The official file of an episode, with numbers of so many decimals; and its states."""
    journal, _ = record(tmp_path, ticks=12, map=the_map)
    original = read_episode(finalise(journal))
    text = json.dumps([recorder_steps(original)])
    path = tmp_path / "steps.json"
    path.write_text(json.dumps(json.loads(text, parse_float=lambda number: round(float(number), decimals))))
    return path, original.states


def imported(path: Path, folder: Path) -> tuple[ImportReport, Path]:
    (source,) = read(path)
    report = import_source(source, folder, "salt")
    assert report.problem == ""
    return report, folder / report.recording


def test_rounded_numbers_are_of_the_map_as_designed(tmp_path: Path) -> None:
    path, _ = file_of(tmp_path, moved(DESIGNED, 3e-7), decimals=6)
    report, made = imported(path, tmp_path / "in")
    assert report.differences and not report.varied
    assert not is_varied(made) and read_episode(made).header.map == DESIGNED


def test_states_stay_as_they_are_and_the_last_tick_is_simulated_from_them(tmp_path: Path) -> None:
    path, states = file_of(tmp_path, moved(DESIGNED, 4e-4))
    report, made = imported(path, tmp_path / "in")
    assert (report.last_tick, report.drift_tick) == ("simulated", 0)
    assert 3e-4 < report.drift < 0.1, "from the map as designed, as `verify` sees it"
    assert plain(read_episode(made).states) == plain(states)
    divergence = verify(made).first_divergence
    assert divergence is not None and divergence.tick == 0


@pytest.mark.parametrize(
    "other",
    [
        replace(DESIGNED, walls=DESIGNED.walls[::-1]),
        replace(DESIGNED, goals=tuple(replace(one, x0=one.x0 + 3e-8) for one in DESIGNED.goals)),
        replace(DESIGNED, items=(replace(FIRST, mass=FIRST.mass + 3e-8), *DESIGNED.items[1:])),
        moved(DESIGNED, 9e-4),
    ],
)
def test_what_makes_no_other_map(other: MapSpec) -> None:
    assert other != DESIGNED and is_as_designed(DESIGNED, other)


@pytest.mark.parametrize(
    "other",
    [
        replace(DESIGNED, walls=DESIGNED.walls[1:]),
        replace(DESIGNED, goals=tuple(replace(one, x0=one.x0 + 0.01) for one in DESIGNED.goals)),
        replace(DESIGNED, items=(replace(FIRST, scale=0.11), *DESIGNED.items[1:])),
        replace(DESIGNED, items=(replace(FIRST, mass=0.12), *DESIGNED.items[1:])),
        replace(DESIGNED, items=DESIGNED.items[1:]),
        moved(DESIGNED, 2e-3),
    ],
)
def test_what_makes_another_map(other: MapSpec) -> None:
    assert not is_as_designed(DESIGNED, other)


@pytest.mark.parametrize(
    ("by", "said"),
    [
        (1e-5, ["maps: 1 differ from the map as designed, 1 of them by a hair: they count as designed"]),
        (
            0.05,
            [
                "maps: 1 differ from the map as designed",
                "! HandOff: 1 count as varied (Challenge 2), by pose of item 0, start of blue",
            ],
        ),
    ],
)
def test_the_command_says_what_counts_as_varied(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], by: float, said: list[str]
) -> None:
    path, _ = file_of(tmp_path, moved(DESIGNED, by))
    assert main(["recordings", "import", str(path), "--out", str(tmp_path / "in"), "--workers", "1"]) == 0
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()]
    assert all(line in lines for line in said) and sum("Challenge 2" in line for line in lines) == len(said) - 1


def test_what_was_imported_as_varied_before_still_counts_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was said to count as designed, while `split --challenge 1` left it out."""
    path, _ = file_of(tmp_path, moved(DESIGNED, 3e-7), decimals=6)
    with monkeypatch.context() as earlier:
        earlier.setattr(map_match, "is_as_designed", lambda designed, found: False)
        assert imported(path, tmp_path / "in")[0].varied
    report, made = imported(path, tmp_path / "in")
    assert report.varied and is_varied(made)
    assert main(["recordings", "import", str(path), "--out", str(tmp_path / "in"), "--workers", "1"]) == 0
    said = capsys.readouterr().out
    assert "imported before, on a varied map; nothing changed. To count it as designed, import it into a new" in said
    assert "! HandOff: 1 count as varied (Challenge 2)" in said and "count as designed\n" not in said
