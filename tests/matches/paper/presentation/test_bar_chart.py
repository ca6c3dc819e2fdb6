"""A figure as bars, which hang down from the axis where a number is negative."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.cells import MeasuredCell, Measurement
from movingout.matches.paper.presentation.bar_chart import HEIGHT, TOP, bar_chart
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.workspace import Workspace
from movingout.world.estimates import Estimate

BASE = TOP + HEIGHT


def _picture(mean: float, error: float | None) -> str:
    """Of a folder in which every number of DP is this."""
    measurement = Measurement("known", "what is known", lambda space, training: {})
    space, entry = Workspace(budget=BUDGETS["smoke"]), ENTRIES["fig:results_t2"]
    space.keep("known", {"any": Estimate(mean, error, 12)})
    rows = {("Challenge 2", "DP"): lambda column: MeasuredCell(measurement, "any")}
    return bar_chart(replace(entry, rows=rows), space)


def _height(picture: str) -> float:
    return float(picture.partition('viewBox="0 0 ')[2].partition('"')[0].split()[1])


def test_a_negative_bar_hangs_down_and_names_stand_below_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    above, below = _picture(0.25, 0.05), _picture(-0.25, 0.05)
    assert set(re.findall(r'class="ours" x="[^"]+" y="([^"]+)" width="18" height="([^"]+)"', above)) == {
        (f"{BASE - HEIGHT / 4:.1f}", f"{HEIGHT / 4:.1f}")
    }
    assert set(re.findall(r'class="ours" x="[^"]+" y="([^"]+)" width="18" height="([^"]+)"', below)) == {
        (f"{BASE:.1f}", f"{HEIGHT / 4:.1f}")
    }
    assert 'height="-' not in below and ">-0.25</text>" in below
    room = _height(below) - _height(above)
    assert room > HEIGHT * 0.3, "of the bar and its error"
    assert f'y="{BASE + 18}" text-anchor="middle">DP</text>' in above
    assert f'y="{BASE + room + 18:.0f}" text-anchor="middle">DP</text>' in below
