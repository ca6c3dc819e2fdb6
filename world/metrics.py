"""The metrics of an episode: one table that names them, their values during and after play, and the official variants.

`METRICS` is the one list of metrics: tables, reports, file schemas, exports and the table in docs/metrics.md are made
from it. To add a metric, add a row there, a field of `Metrics` and its computation. A metric without a value is None;
only files and the wire, where a number must stand, write it as `NO_VALUE`.

Source of the four of the paper: its section "Details of Evaluation Metrics". A tick is judged by the state *before* it,
in which its actions were chosen. Where the official code computes something else under the same name, `OfficialMetrics`
has it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec
from movingout.maps.spec import Size
from movingout.world.constants import TICK_SECONDS
from movingout.world.distance import Distances, official_distances, paper_distances
from movingout.world.interdependence import NOTHING, Interdependence
from movingout.world.scoring import delivered_items, delivered_many, goal_boxes, is_delivered
from movingout.world.state import Floats, WorldState

WEIGHTS: dict[Size, float] = {"small": 1.0, "middle": 2.0, "large": 2.0}


NO_VALUE = -1.0  # written for None where a number must stand
Values = Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class Metric:
    """What a metric is called, what it means and how it is shown."""

    key: str  # in code, JSON, files and tables
    symbol: str
    title: str
    unit: str  # empty for none
    low: float | None  # bounds of its values, None where there is none
    high: float | None
    higher_is_better: bool
    digits: int  # after the point, for people
    meaning: str
    none_when: str = ""  # why it may have no value; empty when it always has one
    from_paper: bool = True
    definition: str = ""  # for docs/metrics.md, where it says more than `meaning`
    official: str = "–"  # for docs/metrics.md: what the official code computes under the same name

    @property
    def heading(self) -> str:
        """The symbol with its unit, for the head of a column."""
        return f"{self.symbol} [{self.unit}]" if self.unit else self.symbol

    @property
    def bounds(self) -> str:
        """The unit, or the interval of its values: "s", "[0, 1]"; empty when it has neither."""
        if self.unit or self.low is None or self.high is None:
            return self.unit
        return f"[{self.low:g}, {self.high:g}]"

    @property
    def description(self) -> str:
        """One line for schemas and data dictionaries."""
        source = " (paper)" if self.from_paper else ""
        return f"{self.title.lower()}{source}: {self.meaning}"

    @property
    def documentation(self) -> str:
        """`description`, and when the cell of a table is empty."""
        return self.description + (f"; empty when {self.none_when}" if self.none_when else "")

    def text(self, value: float | None) -> str:
        """A value for people, with its unit."""
        return "–" if value is None else f"{value:.{self.digits}f} {self.unit}".rstrip()


METRICS = (
    Metric(
        key="tcr",
        symbol="TCR",
        title="Task completion rate",
        unit="",
        low=0.0,
        high=1.0,
        higher_is_better=True,
        digits=2,
        meaning="delivered items / items, middle and large ones counting twice",
        official="counts every item once (`score`)",
    ),
    Metric(
        key="nfd",
        symbol="NFD",
        title="Normalised final distance",
        unit="",
        low=None,
        high=1.0,
        higher_is_better=True,
        digits=2,
        meaning="share of the items' way to a goal that was covered; negative when they went farther away",
        definition="1 - (sum of the items' distances to a goal) / (the same at the start), breadth-first on 48 x 48 "
        "cells around the walls, 8 directions; negative when items went farther away",
        official="straight lines on maps without walls, a 49 x 49 grid on others",
    ),
    Metric(
        key="wt_s",
        symbol="WT",
        title="Waiting time",
        unit="s",
        low=0.0,
        high=None,
        higher_is_better=False,
        digits=1,
        meaning="time in which an agent alone held a middle or large item, both agents added",
        definition="seconds in which an agent alone holds a middle or large item that is not delivered, both agents "
        "added",
        official="fraction of ticks; not while the partner carries a small item; delivered items too",
    ),
    Metric(
        key="ac",
        symbol="AC",
        title="Action consistency",
        unit="",
        low=0.0,
        high=1.0,
        higher_is_better=True,
        digits=2,
        meaning="share of the pushing that agreed while both held one item",
        none_when="nothing was carried together",
        definition="mean over ticks with both hands on one item of |(f1 + f2) · d| / (|f1| + |f2|): f what each agent "
        "commands, d the direction from one to the other; ticks in which neither pushes are left out",
        official="1 - wasted / total, where only pushes against each other along d are wasted, with headings a quarter "
        "turn off",
    ),
    Metric(
        key="interdependence",
        symbol="INT",
        title="Interdependence",
        unit="",
        low=0.0,
        high=1.0,
        higher_is_better=True,
        digits=2,
        meaning="share of deliveries that the partner enabled by carrying the item a part of the way",
        none_when="nothing that was held is delivered",
        from_paper=False,
        definition="share of the deliveries that the deliverer's partner enabled (below)",
    ),
)


@dataclass(frozen=True, slots=True)
class Metrics:
    """The metrics of an episode so far; the fields are the keys of `METRICS`."""

    tcr: float
    nfd: float
    wt_s: float | None  # None only for an episode that could not be played
    ac: float | None
    interdependence: float | None

    def values(self) -> dict[str, float | None]:
        """By key, in the order of `METRICS`."""
        return {metric.key: getattr(self, metric.key) for metric in METRICS}

    @classmethod
    def of(cls, values: Values) -> "Metrics":
        """The inverse of `values`; a metric that an older file does not have is None. KeyError for TCR, NFD and WT."""
        found: dict[str, Any] = {
            metric.key: values.get(metric.key) if metric.none_when else values[metric.key] for metric in METRICS
        }
        return cls(**found)


def to_numbers(values: Values) -> dict[str, float]:
    """For files and the wire: `NO_VALUE` for None."""
    return {key: NO_VALUE if value is None else value for key, value in values.items()}


def from_numbers(numbers: Mapping[str, float]) -> dict[str, float | None]:
    """What `to_numbers` wrote, by key of `METRICS`; None for a metric that an older file does not have."""
    return {metric.key: _value(metric, numbers.get(metric.key)) for metric in METRICS}


def _value(metric: Metric, number: float | None) -> float | None:
    return None if metric.none_when and number == NO_VALUE else number


@dataclass(frozen=True, slots=True)
class OfficialMetrics:
    """What the official code reports under these names."""

    score: float  # `global_score`: delivered items / items, without the paper's weights by size
    nfd: float  # `global_dense_reward`: straight lines on maps without walls, else the 49 x 49 grid
    waiting: float  # fraction of ticks in which one holds a middle or large item and nobody helps; not seconds
    consistency: float  # mean of 1 - wasted / total over ticks of joint holding, see `official_tick_consistency`


class EpisodeMetrics:
    """Accumulates an episode tick by tick; `update` takes microseconds, `result` may be called at any time.

    Waiting time, WT = sum over waiting intervals of (end - start): an agent waits while it alone holds a middle or
    large item that is not delivered yet. Dragging a middle item alone, at a tenth of the speed, counts as waiting too,
    and both agents may wait at once. Intervals are counted in ticks.
    """

    def __init__(self, map_spec: MapSpec) -> None:
        self.map = map_spec
        self._goals = goal_boxes(map_spec)
        self._big = (*(item.size != "small" for item in map_spec.items), False)  # the last one is "holds nothing", -1
        self._initial = np.array([(item.pose.x, item.pose.y) for item in map_spec.items]).reshape(-1, 2)
        self._final: Floats | None = None
        self._ticks = 0
        self._waiting = 0  # agent-ticks
        self._consistency: list[float] = []
        self._official_waiting = 0
        self._official_consistency: list[float] = []
        distances, farthest, _ = _to_be_carried(map_spec)
        self._interdependence = Interdependence(
            len(map_spec.items), lambda point: min(distances.one_to_goal(point), farthest)
        )

    def update(self, before: WorldState, actions: Floats, after: WorldState) -> None:
        """Take in one tick: the state before it, its world actions (2, 3) and the state after it."""
        if not self._ticks:
            self._interdependence.see(before)
        self._interdependence.see(after)
        self._ticks += 1
        self._final = after.item_poses
        blue, red = before.held.tolist()
        if not (self._big[blue] or self._big[red]):
            return
        if blue == red:
            self._update_together(before, actions)
        else:
            self._update_alone(before, blue, red)

    def update_episode(self, states: list[WorldState], actions: Floats) -> None:
        """Take in a whole episode: T + 1 states and the actions (T, 2, 3) between them."""
        for index, action in enumerate(actions):
            self.update(states[index], action, states[index + 1])

    def result(self) -> Metrics:
        """The metrics up to the last tick taken in."""
        poses = self._item_poses()
        delivered = delivered_items(self.map, poses)
        return Metrics(
            tcr=task_completion_rate(self.map, delivered),
            nfd=float(normalized_final_distance(self.map, poses)),
            wt_s=self._waiting * TICK_SECONDS,
            ac=float(np.mean(self._consistency)) if self._consistency else None,
            interdependence=self._interdependence.share(delivered, poses),
        )

    @property
    def waiting_share(self) -> float:
        """The official `waiting`: the share of ticks in which one holds a middle or large item and nobody helps."""
        return self._official_waiting / self._ticks if self._ticks else 0.0

    @property
    def official_ac(self) -> float | None:
        """The official `consistency`, with its 1e-5 in the denominator; None where nothing was carried together."""
        together = self._official_consistency
        return sum(together) / (len(together) + 1e-5) if together else None

    def official(self) -> OfficialMetrics:
        """What the official code would report for the same ticks."""
        poses = self._item_poses()
        return OfficialMetrics(
            score=float(delivered_items(self.map, poses).mean()),
            nfd=official_normalized_final_distance(self.map, poses),
            waiting=self.waiting_share,
            consistency=self.official_ac or 0.0,
        )

    def _update_together(self, before: WorldState, actions: Floats) -> None:
        consistency = tick_consistency(before.robot_poses, actions)
        if consistency is not None:
            self._consistency.append(consistency)
        self._official_consistency.append(official_tick_consistency(before.robot_poses, actions))

    def _update_alone(self, before: WorldState, blue: int, red: int) -> None:
        for held in (blue, red):
            if self._big[held] and not is_delivered(self.map.items[held], tuple(before.item_poses[held]), self._goals):
                self._waiting += 1
        one_hand_is_empty = blue < 0 or red < 0
        self._official_waiting += one_hand_is_empty or (self._big[blue] and self._big[red])

    def _item_poses(self) -> Floats:
        if self._final is not None:
            return self._final
        return np.column_stack((self._initial, [item.pose.angle for item in self.map.items]))


def task_completion_rate(map_spec: MapSpec, delivered: npt.NDArray[np.bool_]) -> float:
    """TCR = sum(w_i [item i delivered]) / sum(w_i), w = 1 small, 2 middle or large; `delivered` is (N,)."""
    weights = np.array([WEIGHTS[item.size] for item in map_spec.items])
    return float(weights @ delivered / weights.sum())


def normalized_final_distance(map_spec: MapSpec, item_poses: Floats) -> Floats:
    """NFD = 1 - sum(d_i final) / sum(d_i initial), for final poses (..., N, 3) and the map's own initial ones: (...).

    d is the breadth-first distance from the item's centre to the nearest goal on the 48 x 48 grid. An item
    that cannot reach a goal counts as the farthest place that can. Where all lie in goal cells from the start, it is 1
    while all are delivered, and 0 otherwise.
    """
    distances, farthest, before = _to_be_carried(map_spec)
    after = np.minimum(distances.to_goal(item_poses[..., :2]), farthest).sum(axis=-1)
    if before == 0.0:
        poses = item_poses.reshape(-1, *item_poses.shape[-2:])
        return delivered_many(map_spec, poses).all(axis=-1).reshape(after.shape).astype(np.float64)
    nfd: Floats = 1.0 - after / before
    return nfd


@lru_cache(maxsize=256)
def _to_be_carried(map_spec: MapSpec) -> tuple[Distances, float, float]:
    """A map's distances, the largest of them, and the sum over all items at the start."""
    distances = paper_distances(map_spec)
    initial = np.array([(item.pose.x, item.pose.y) for item in map_spec.items])
    return distances, distances.farthest, np.minimum(distances.to_goal(initial), distances.farthest).sum()


def tick_consistency(robot_poses: Floats, actions: Floats) -> float | None:
    """One term of AC = 1/T sum |(f1 + f2) . d| / (|f1| + |f2|), over the T ticks with both hands on one item.

    f is the commanded displacement, distance (-sin heading, cos heading), clipped to length 1: what each agent wants,
    and what its motor then pushes for. d is the unit vector from blue to red. The formula is about the line between
    the two: carrying side by side, across that line, scores 0 (the official variant gives 1). None when neither
    pushes or both stand on one point: the term is 0 / 0 and the tick is left out of T.
    """
    (blue_x, blue_y, _), (red_x, red_y, _) = robot_poses.tolist()
    line = math.hypot(red_x - blue_x, red_y - blue_y)
    pushes = [_push(distance, heading) for distance, heading, _ in actions.tolist()]
    total = sum(math.hypot(x, y) for x, y in pushes)
    if line < NOTHING or total < NOTHING:
        return None
    along = ((red_x - blue_x) * (pushes[0][0] + pushes[1][0]) + (red_y - blue_y) * (pushes[0][1] + pushes[1][1])) / line
    return float(min(abs(along) / total, 1.0))


def official_tick_consistency(robot_poses: Floats, actions: Floats) -> float:
    """The official AC of one tick: 1 - wasted / total, 1 when nobody pushes.

    wasted is |p1| + |p2| when the pushes along the line between the agents have opposite signs, else 0. The official
    code takes (cos, sin) of the heading as the direction, a quarter turn from where the robot drives; so does this.
    """
    (blue_x, blue_y, _), (red_x, red_y, _) = robot_poses.tolist()
    line = math.hypot(red_x - blue_x, red_y - blue_y)
    total = sum(abs(distance) for distance, _, _ in actions.tolist())
    if line < NOTHING or total < NOTHING:
        return 1.0
    unit_x, unit_y = (red_x - blue_x) / line, (red_y - blue_y) / line
    along = [d * (math.cos(heading) * unit_x + math.sin(heading) * unit_y) for d, heading, _ in actions.tolist()]
    wasted = abs(along[0]) + abs(along[1]) if along[0] * along[1] < 0 else 0.0
    return float(1.0 - wasted / total)


def official_normalized_final_distance(map_spec: MapSpec, item_poses: Floats) -> float:
    """The official `global_dense_reward`: NFD for final poses (N, 3) with the official distances."""
    to_goal = official_distances(map_spec).to_goal
    initial = sum(to_goal(np.array([item.pose.x, item.pose.y])) for item in map_spec.items)
    final = sum(to_goal(pose[:2]) for pose in item_poses)
    return 1.0 - final / initial if initial else float(final == 0.0)


def _push(distance: float, heading: float) -> tuple[float, float]:
    length = max(-1.0, min(1.0, distance))
    return -length * math.sin(heading), length * math.cos(heading)
