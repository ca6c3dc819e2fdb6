"""Metrics that other installed packages add: entry points of the group `movingout.metrics`.

    # metrics.py of the package, and in its pyproject.toml:  [project.entry-points."movingout.metrics"]
    WALKED = OwnMetric(...)                                 # walked = "my_package.metrics:WALKED"

Tables, grids, reports and exports show them behind our own; recordings do not contain them, since they can be computed
again.
"""

import math
import traceback
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint

from movingout.maps import MapSpec
from movingout.maps.extras import METRICS as GROUP
from movingout.maps.extras import installed, package_of
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c, noticing_ctrl_c
from movingout.world.metrics import METRICS, Metric
from movingout.world.state import Floats, WorldState

COLUMNS = frozenset(
    (
        *("agent", "blue", "blue_checkpoint", "blue_device", "blue_kind", "blue_name", "challenge", "code"),
        *(
            "complete",
            "condition",
            "counts",
            "cpu_s",
            "delivered",
            "distinct",
            "ending",
            "episode_id",
            "episodes",
            "failed",
            "failed_seat",
        ),
        *("failure", "full_deliveries", "id", "items", "limit_ticks", "map", "map_variant", "mean_ticks", "outcome"),
        *(
            "official_ac",
            "own_metrics",
            "partner",
            "play_hash",
            "pymunk",
            "recording",
            "red",
            "red_checkpoint",
            "red_device",
        ),
        *("red_kind", "red_name", "seconds", "seed", "source", "split", "started_utc", "study", "success", "ticks"),
        *(
            "waiting_share",
            "wt",
        ),
    )
)
"""What tables of matches and recordings have beside metrics: a metric of that key would write over it."""

Compute = Callable[[MapSpec, Sequence[WorldState], Floats], float | None]
"""From the map as played, T + 1 states and the world actions (T, 2, 3) between them; None where it has no value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnMetric(Metric):
    """A metric and how it is computed; `key` is its column in files."""

    compute: Compute
    from_paper: bool = False


@cache
def own_metrics() -> tuple[OwnMetric, ...]:
    """Those that can be loaded; a warning says why one cannot."""
    found: dict[str, OwnMetric] = {}
    taken = COLUMNS | {metric.key for metric in METRICS}
    for entry in installed(GROUP).values():
        metric = _loaded(entry)
        if metric is not None and metric.key in (taken | found.keys()):
            _warn(entry, f"its key {metric.key!r} is taken")
        elif metric is not None:
            found[metric.key] = metric
    return tuple(found.values())


def own_values(map_spec: MapSpec, states: Sequence[WorldState], actions: Floats) -> dict[str, float | None]:
    """The values of an episode by key; None, with a warning, where a computation failed or gave no finite number.

    Each gets arrays of its own: what it writes into them is neither in an export nor seen by the next metric.
    """
    return {
        metric.key: _value(metric, map_spec, [state.copy() for state in states], actions.copy())
        for metric in own_metrics()
    }


def _value(metric: OwnMetric, map_spec: MapSpec, states: Sequence[WorldState], actions: Floats) -> float | None:
    with noticing_ctrl_c():
        try:
            value = metric.compute(map_spec, states, actions)
            number = None if value is None else float(value)
            if number is None or math.isfinite(number):
                return number
            why = f"its value is {number}, no finite number"  # which JSON cannot say
        except FOREIGN_CODE_RAISES as error:
            if is_ctrl_c(error):
                raise
            place = traceback.extract_tb(error.__traceback__)[-1]
            why = f"{type(error).__name__}: {error} ({place.filename}, line {place.lineno})"
    warnings.warn(f"the metric {metric.key} failed, its cells stay empty: {why}", RuntimeWarning, stacklevel=3)
    return None


def _loaded(entry: EntryPoint) -> OwnMetric | None:
    with noticing_ctrl_c():
        try:
            metric = entry.load()
        except FOREIGN_CODE_RAISES as error:
            if is_ctrl_c(error):
                raise
            _warn(entry, f"{type(error).__name__}: {error}")
            return None
    if isinstance(metric, OwnMetric) and metric.key.isidentifier() and callable(metric.compute):
        return metric
    _warn(entry, f"{entry.value} is no OwnMetric whose key is a name and whose compute is a function")
    return None


def _warn(entry: EntryPoint, why: str) -> None:
    warnings.warn(f"the metric {entry.name} of {package_of(entry)} is left out: {why}", RuntimeWarning, stacklevel=3)
