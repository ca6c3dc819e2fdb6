"""Which servers accept simulated participants, and the errors of the others."""

import asyncio
from pathlib import Path

import pytest

from movingout.server.study_bots.cohort import Cohort
from movingout.server.study_bots.simulation_plan import SimulationPlan
from movingout.server.study_bots.study_client import SimulationError
from tests.server.study.support import served


def _visit(base: str) -> None:
    asyncio.run(Cohort(base, SimulationPlan(1, scripted=False)).take_part())


def test_a_study_of_real_people_is_never_visited(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        with pytest.raises(SimulationError, match="real participants"):
            _visit(f"http://{study.live.address}")
        assert study.state()["participants"] == []


def test_where_nothing_is_served_it_is_said_so() -> None:
    with pytest.raises(SimulationError, match="no study is being served at http"):
        _visit("http://127.0.0.1:9")
