"""Metrics of installed packages: which keys they may have, and which values count."""

import math
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from types import SimpleNamespace
from typing import Any, NoReturn

import numpy as np
import pytest

from movingout.maps import MapSpec, load_map
from movingout.matches.commands.match import _row_json
from movingout.matches.match import Match, failed_result
from movingout.matches.results.table import OFFICIAL_AC, WAITING, ResultRow
from movingout.recordings.exports.tables import EPISODES
from movingout.recordings.report.measures import MEASURES
from movingout.world import World
from movingout.world import own_metrics as module
from movingout.world.metrics import METRICS
from movingout.world.own_metrics import COLUMNS, Compute, OwnMetric, own_metrics, own_values
from movingout.world.state import Floats, WorldState

Install = Callable[[str, Compute], None]


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Makes a metric one of an installed package."""

    def put(key: str, compute: Compute) -> None:
        common: dict[str, Any] = {"symbol": "X", "title": "X", "meaning": "x", "unit": "", "low": None, "high": None}
        metric = OwnMetric(key=key, compute=compute, higher_is_better=True, digits=1, **common)
        entry = SimpleNamespace(name=key, value="plugged:X", load=lambda: metric)
        monkeypatch.setattr(module, "installed", lambda group: {key: entry})
        monkeypatch.setattr(module, "package_of", lambda entry: "plugged 1.0")
        own_metrics.cache_clear()

    yield put
    own_metrics.cache_clear()


@pytest.mark.parametrize("value", [math.nan, math.inf, np.float32("-inf")])
def test_a_value_that_is_no_finite_number_is_none_with_a_warning(install: Install, value: float) -> None:
    """A grid ended in `ValueError: Out of range float values are not JSON compliant`."""
    install("walked", lambda the_map, states, actions: value)
    with pytest.warns(RuntimeWarning, match="the metric walked failed, its cells stay empty: its value is .*(nan|inf)"):
        assert own_values(load_map("HandOff"), [], np.zeros((0, 2, 3))) == {"walked": None}


def test_finite_values_and_none_stay(install: Install) -> None:
    install("walked", lambda the_map, states, actions: states[0].tick if states else None)
    states = [World(load_map("HandOff")).state()]
    for some, value in ((states, 0.0), ([], None)):
        assert own_values(load_map("HandOff"), some, np.zeros((0, 2, 3))) == {"walked": value}


def test_a_metric_that_writes_into_its_arrays_changes_no_others(install: Install) -> None:
    """Exports had the rows as a metric left them, and the next metric computed from them."""

    def writes(the_map: MapSpec, states: Sequence[WorldState], actions: Floats) -> float:
        states[0].item_poses[:] = actions[:] = 9.0
        return 1.0

    install("walked", writes)
    state, actions = World(load_map("HandOff")).state(), np.zeros((1, 2, 3))
    before = state.item_poses.copy()
    assert own_values(load_map("HandOff"), [state, state], actions) == {"walked": 1.0}
    assert np.array_equal(state.item_poses, before)
    assert not actions.any()


def test_a_package_that_ends_the_program_is_left_out_with_a_warning(
    install: Install, monkeypatch: pytest.MonkeyPatch
) -> None:
    install("walked", lambda the_map, states, actions: sys.exit("no licence"))
    with pytest.warns(RuntimeWarning, match="the metric walked failed, its cells stay empty: SystemExit: no licence"):
        assert own_values(load_map("HandOff"), [], np.zeros((0, 2, 3))) == {"walked": None}
    entry = SimpleNamespace(name="walked", value="plugged:X", load=lambda: sys.exit("no licence"))
    monkeypatch.setattr(module, "installed", lambda group: {"walked": entry})
    own_metrics.cache_clear()
    with pytest.warns(RuntimeWarning, match=r"metric walked of plugged 1.0 is left out: SystemExit: no licence"):
        assert own_metrics() == ()


def _interrupts(*_: object) -> NoReturn:
    raise KeyboardInterrupt("mine")


def _is_interrupted(*_: object) -> float:
    """Somebody presses Ctrl-C meanwhile."""
    signal.raise_signal(signal.SIGINT)
    return 1.0


def test_a_keyboard_interrupt_of_a_package_is_its_fault_and_no_ctrl_c(
    install: Install, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It ended commands as if somebody had pressed Ctrl-C."""
    install("walked", _interrupts)
    with pytest.warns(RuntimeWarning, match="the metric walked failed, its cells stay empty: KeyboardInterrupt: mine"):
        assert own_values(load_map("HandOff"), [], np.zeros((0, 2, 3))) == {"walked": None}
    install("walked", _is_interrupted)
    with pytest.raises(KeyboardInterrupt):
        own_values(load_map("HandOff"), [], np.zeros((0, 2, 3)))
    for load in (_interrupts, _is_interrupted):
        entry = SimpleNamespace(name="walked", value="plugged:X", load=load)
        monkeypatch.setattr(module, "installed", lambda group, entry=entry: {"walked": entry})
        own_metrics.cache_clear()
        if load is _is_interrupted:
            with pytest.raises(KeyboardInterrupt):
                own_metrics()
        else:
            with pytest.warns(RuntimeWarning, match=r"metric walked of plugged 1.0 is left out: KeyboardInterrupt"):
                assert own_metrics() == ()


@pytest.mark.parametrize("key", ["ticks", "agent", "tcr", "waiting_share", "official_ac", "episode_id", "wt"])
def test_a_key_that_is_a_column_already_is_refused(install: Install, key: str) -> None:
    """`ticks` wrote over the ticks of every match."""
    install(key, lambda the_map, states, actions: 1.0)
    with pytest.warns(RuntimeWarning, match=f"left out: its key '{key}' is taken"):
        assert own_metrics() == ()


def test_the_list_has_every_column_of_matches_results_and_recordings() -> None:
    result = failed_result(Match("HandOff", "idle", "idle", 0), "")
    row = ResultRow("one", 1, "idle", "idle", "HandOff", (result,))
    whole = row.to_json()
    compared = [WAITING.key, OFFICIAL_AC.key]
    tables = (result.to_json(), whole, _row_json(whole), [column.name for column in EPISODES], MEASURES, compared)
    assert {name for table in tables for name in table} - {metric.key for metric in METRICS} == COLUMNS
