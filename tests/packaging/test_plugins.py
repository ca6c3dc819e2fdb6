"""An agent and a metric of another installed package appear wherever agents and metrics do."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.support import ROOT

METRICS = """
from movingout.world.own_metrics import OwnMetric

def ticks(the_map, states, actions):
    return float(len(actions))

def broken(the_map, states, actions):
    return 1 / 0

COMMON = dict(unit="", low=0.0, high=None, higher_is_better=False, digits=0)
TICKS = OwnMetric(key="ticks_played", symbol="TP", title="Ticks played", meaning="how many", compute=ticks, **COMMON)
BROKEN = OwnMetric(key="broken", symbol="BR", title="Broken", meaning="none", compute=broken, **COMMON)
"""
AGENTS = """
import numpy as np

class Ahead:
    def __init__(self, speed=1.0):
        self.speed = speed

    def reset(self, episode):
        pass

    def act(self, observation):
        return np.array([[self.speed, 1.0, 0.0, 0.0]])
"""
ENTRIES = """[movingout.agents]
ahead = plugged.agents:Ahead
scripted = plugged.agents:Ahead

[movingout.metrics]
ticks = plugged.metrics:TICKS
broken = plugged.metrics:BROKEN
missing = plugged.metrics:MISSING
"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A folder with an installed package `plugged`."""
    for name, text in {
        "plugged/__init__.py": "",
        "plugged/metrics.py": METRICS,
        "plugged/agents.py": AGENTS,
        "plugged-1.0.dist-info/METADATA": "Metadata-Version: 2.1\nName: plugged\nVersion: 1.0\n",
        "plugged-1.0.dist-info/entry_points.txt": ENTRIES,
    }.items():
        (tmp_path / "site" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "site" / name).write_text(text)
    return tmp_path / "site"


def movingout(site: Path, *words: str) -> subprocess.CompletedProcess[str]:
    paths = os.pathsep.join([str(ROOT / "src"), str(site)])
    command = [sys.executable, "-P", "-m", "movingout.server.cli", *words]
    around = {**os.environ, "PYTHONPATH": paths}
    return subprocess.run(
        command, cwd=site.parent, env=around, capture_output=True, text=True, timeout=200, check=False
    )


@pytest.mark.slow
def test_an_installed_agent_is_listed_and_plays_and_a_taken_name_is_told(site: Path) -> None:
    listed = movingout(site, "agents", "list", "--json")
    (card,) = [card for card in json.loads(listed.stdout)["agents"] if card["id"] == "ahead"]
    assert card["description"] == "Of the package plugged 1.0: plugged.agents:Ahead."
    assert "left out: the agent 'scripted' of plugged 1.0: its name is taken" in listed.stderr
    shown = movingout(site, "agents", "show", "ahead:speed=2,turn=1")
    assert shown.returncode == 2 and "options: speed" in shown.stderr


@pytest.mark.slow
def test_an_installed_metric_is_in_tables_grids_reports_and_parquet(site: Path) -> None:
    (site.parent / "grid.yaml").write_text(
        "name: own\nagents: [ahead]\npartners: [idle]\nmaps: [HandOff]\nseeds: 1\nticks: 7\n"
    )
    played = movingout(site, "match", "grid", "grid.yaml", "--out", "out", "--record", "--html")
    assert played.returncode == 0, played.stderr
    assert "the metric missing of plugged 1.0 is left out" in played.stderr
    assert "the metric broken failed, its cells stay empty: ZeroDivisionError" in played.stderr
    out = site.parent / "out"
    row = json.loads((out / "results.json").read_text())["results"][0]
    assert row["ticks_played"]["mean"] == 7.0 and row["broken"]["mean"] is None
    assert "TP" in (out / "results.md").read_text() and "TP" in (out / "results.html").read_text()
    assert pq.read_table(out / "results.parquet")["ticks_played"].to_pylist() == [7.0]
    report = movingout(site, "recordings", "report", "out/recordings", "--out", "r.html")
    assert report.returncode == 0 and "Ticks played" in (site.parent / "r.html").read_text(), report.stderr
    movingout(site, "recordings", "export", "out/recordings", "--to", "parquet", "--out", "tables")
    assert pq.read_table(site.parent / "tables" / "episodes.parquet")["ticks_played"].to_pylist() == [7.0]
    assert (
        "Ticks played" in (site.parent / "tables" / "DATA_DICTIONARY.md").read_text()
        or "ticks played" in (site.parent / "tables" / "DATA_DICTIONARY.md").read_text()
    )
