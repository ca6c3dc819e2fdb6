"""An episode as arrays over time, in which waiting and failure cases are found."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from movingout.maps.spec import ItemSpec, MapSpec
from movingout.maps.surface import surface_distance
from movingout.recordings.episode import Episode
from movingout.world.constants import REACH
from movingout.world.distance import paper_distances
from movingout.world.state import Floats

Mask = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]


class Span(NamedTuple):
    """The ticks `start` up to, not including, `end`."""

    start: int
    end: int

    @property
    def ticks(self) -> int:
        return self.end - self.start

    def later(self, ticks: int) -> "Span":
        return Span(self.start + ticks, self.end + ticks)


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """T + 1 states and the T actions between them."""

    map: MapSpec
    robots: Floats  # (T + 1, 2, 3) x, y, angle
    items: Floats  # (T + 1, N, 3)
    held: Ints  # (T + 1, 2) index into the items, -1 none
    delivered: Mask  # (T + 1, N)
    grasp: Mask  # (T, 2) whether a toggle of the grasp was commanded

    @classmethod
    def of(cls, episode: Episode) -> "Track":
        spec, states = episode.header.map, episode.states
        return cls(
            map=spec,
            robots=np.array([state.robot_poses for state in states]),
            items=np.array([state.item_poses for state in states]),
            held=np.array([state.held for state in states]),
            delivered=np.array([episode.delivered_after(tick) for tick in range(len(states))], dtype=np.bool_),
            grasp=episode.actions[:, :, 2] >= 0.5,
        )

    def is_big(self, item: int) -> bool:
        """Whether an item needs two robots, or is faster with two: middle and large."""
        return self.map.items[item].size != "small"

    def alone(self, seat: int, item: int) -> Mask:
        """(T + 1,) whether this seat alone holds the item, before it is delivered."""
        mine, other = self.held[:, seat] == item, self.held[:, 1 - seat] == item
        alone: Mask = mine & ~other & ~self.delivered[:, item]
        return alone

    def probe(self, seat: int) -> Floats:
        """(T + 1, 2) the point in front of a robot at which it grasps."""
        angle = self.robots[:, seat, 2]
        ahead = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        point: Floats = self.robots[:, seat, :2] + REACH * ahead
        return point

    def clearance(self, item: int, points: Floats) -> Floats:
        """(T + 1,) distance from points (T + 1, 2) to the surface of the item at that time, 0 inside."""
        return clearance(self.map.items[item], self.items[:, item], points)

    def to_goal(self, points: Floats) -> Floats:
        """(...) distance of points (..., 2) to the nearest goal, as NFD measures it."""
        distances = paper_distances(self.map)
        way: Floats = np.minimum(distances.to_goal(points), distances.farthest)
        return way


def clearance(item: ItemSpec, poses: Floats, points: Floats) -> Floats:
    """(T,) distances from points (T, 2) to an item's surface in poses (T, 3), 0 inside."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    dx, dy = (points - poses[:, :2]).T
    local = np.stack([cos * dx + sin * dy, cos * dy - sin * dx], axis=1)
    gap: Floats = np.maximum(surface_distance(item.shape, item.scale, local), 0.0)
    return gap


def spans(mask: Mask, at_least: int = 1, gap: int = 0) -> Iterator[Span]:
    """Runs of True in `mask`: runs at most `gap` ticks apart are joined, runs shorter than `at_least` are dropped."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    joined: list[Span] = []
    for start, end in edges.reshape(-1, 2).tolist():
        if joined and start - joined[-1].end <= gap:
            start = joined.pop().start
        joined.append(Span(start, end))
    yield from (span for span in joined if span.ticks >= at_least)
