"""Shortest ways for a robot's centre between any two points of a map, exact to its geometry.

Ways are straight lines between the corners of the walls, which are grown by a robot's radius (a visibility graph).
Places are not rounded to a grid, so that a mirrored or turned map has the mirrored or turned ways; of two equally
long ones, which is taken hangs on rounding. Items are no obstacles.
Everything works on arrays: T states at once, P points in each.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec, Rect
from movingout.maps.spec import ARENA_HALF
from movingout.world.state import Floats

FAR = 6.0  # [u] length where there is no way; the longest way on the twelve maps is under 5
CLEARANCE = 0.12  # [u] between a way and a wall
_CORNER = 0.135  # [u] ways turn this far from a wall's corner
_TURN = 0.15  # [u] nearer than this to a turn, the direction already leads on
_INSIDE_GOAL = 0.1  # [u] ways to a goal region end this far inside of it
_TINY = 1e-9
_AT_ONCE = 1 << 14  # lines times walls; what is computed with so many stays in a processor's cache

Flags = npt.NDArray[np.bool_]


class Ways(NamedTuple):
    """From points to points: unit vectors (..., 2) along the way, lengths (...) [u], whether it is straight (...)."""

    directions: Floats
    lengths: Floats
    straight: Flags


class Seen(NamedTuple):
    """Points (T, P, 2), and their distances (T, P, C) to the corners that are in a straight line, else infinite."""

    points: Floats
    corners: Floats


class _Columns(NamedTuple):
    """Points as two arrays of numbers."""

    x: Floats
    y: Floats


class WayFinder:
    """Ways on one map with C corners."""

    def __init__(self, walls: tuple[Rect, ...], goals: tuple[Rect, ...]) -> None:
        self.walls = np.array([(r.left, r.bottom, r.right, r.top) for r in walls]).reshape(-1, 4)
        self.corners = self._corners()
        self._goals = np.array([_inner(goal) for goal in goals])
        apart = np.linalg.norm(self.corners[:, None] - self.corners[None], axis=-1)
        self._edges = np.where(self.blocked(self.corners[:, None], self.corners[None]), np.inf, apart)
        self._along = self._edges.copy()  # (C, C) lengths of ways between corners
        for middle in range(len(self.corners)):
            np.minimum(self._along, self._along[:, middle, None] + self._along[None, middle], out=self._along)
        self._to_corners = np.ascontiguousarray(self._along.T)
        self._from_corners, self._entries = self._ways_to_goals()

    def seen(self, points: Floats) -> Seen:
        """Points (T, P, 2) with what is to be known of them for every way that begins or ends there."""
        apart = np.linalg.norm(points[:, :, None] - self.corners, axis=-1)
        return Seen(points, np.where(self.blocked(points[:, :, None], self.corners), np.inf, apart))

    def between(self, start: Seen, target: Seen) -> Ways:
        """From each point of `start` to the one of `target` in the same place; either may have one for all."""
        beeline = target.points - start.points
        apart = np.linalg.norm(beeline, axis=-1)
        straight = ~self.blocked(start.points, target.points)
        if not len(self.corners):
            return _ways(beeline, np.where(straight, apart, FAR), straight)
        beyond = self._beyond(target)
        around = start.corners + beyond
        first = around.argmin(axis=-1)
        lengths = np.where(straight, apart, np.take_along_axis(around, first[..., None], axis=-1)[..., 0])
        after = self._next(first, target, beyond)
        towards = self._carrot(np.broadcast_to(start.points, beeline.shape), self.corners[first], after)
        return _ways(np.where((straight | np.isinf(lengths))[..., None], beeline, towards), lengths, straight)

    def to_goals(self, start: Seen) -> Ways:
        """From points (T, P) to each of the G goal regions: arrays (T, P, G)."""
        shape = (*start.points.shape[:2], len(self._goals))
        here = np.broadcast_to(start.points[:, :, None], (*shape, 2)).reshape(shape[0], -1, 2)
        low, high = self._goals[:, :2], self._goals[:, 2:]
        there = np.clip(start.points[:, :, None], low, high).reshape(shape[0], -1, 2)
        corners = np.broadcast_to(start.corners[:, :, None], (*shape, len(self.corners)))
        apart = np.linalg.norm(there - here, axis=-1)
        straight = ~self.blocked(here, there)
        beeline = there - here
        if not len(self.corners):
            found = _ways(beeline, np.where(straight, apart, FAR), straight)
        else:
            around = corners.reshape(shape[0], -1, len(self.corners)) + np.tile(self._from_corners, (shape[1], 1))
            first = around.argmin(axis=-1)
            goal = np.tile(np.arange(len(self._goals)), shape[1])
            lengths = np.where(straight, apart, np.take_along_axis(around, first[..., None], axis=-1)[..., 0])
            towards = self._carrot(here, self.corners[first], self._entries[goal, first])
            found = _ways(np.where((straight | np.isinf(lengths))[..., None], beeline, towards), lengths, straight)
        return Ways(found.directions.reshape(*shape, 2), found.lengths.reshape(shape), found.straight.reshape(shape))

    def _ways_to_goals(self) -> tuple[Floats, Floats]:
        """For each goal region and corner: the length of the way (G, C) and the next turn or entry (G, C, 2)."""
        entry = np.clip(self.corners, self._goals[:, None, :2], self._goals[:, None, 2:])
        if not len(self.corners):
            return np.zeros(entry.shape[:2]), entry
        direct = np.linalg.norm(entry - self.corners, axis=-1)
        direct = np.where(self.blocked(self.corners, entry), np.inf, direct)
        through = self._along[None] + direct[:, None]  # (G, C, C) to a corner, then in
        lengths = through.min(axis=-1)
        step = self._edges[None] + np.where(np.eye(len(self.corners), dtype=bool), np.inf, lengths[:, None])
        after = self.corners[step.argmin(axis=-1)]
        return lengths, np.where((direct <= lengths + _TINY)[..., None], entry, after)

    def blocked(self, start: Floats, target: Floats) -> Flags:
        """Whether the straight line between points (..., 2) comes nearer to a wall than a robot can.

        At a point that is itself nearer (an item beside a wall), its own distance counts instead.
        """
        axes = max(start.ndim, target.ndim) - 1
        here, there = _columns(start, axes), _columns(target, axes)
        steps = there.x - here.x, there.y - here.y
        step = _Columns(*(np.where(np.abs(one) < _TINY, _TINY, one) for one in steps))
        blocked: Flags = np.zeros(step.x.shape, dtype=bool)
        at_once = max(1, _AT_ONCE // max(1, blocked.size))
        for first in range(0, len(self.walls), at_once):
            walls = self.walls[first : first + at_once].T.reshape(4, -1, *[1] * axes)
            blocked |= _met(walls, here, there, step).any(axis=0)
        return blocked

    def rays(self, origins: Floats, directions: Floats) -> Floats:
        """How far it is to the first wall or side of the arena, (T, K), from origins (T, 2) in directions (T, K, 2)."""
        step = np.where(np.abs(directions) < _TINY, _TINY, directions)
        ends = (np.where(step > 0.0, ARENA_HALF, -ARENA_HALF) - origins[:, None]) / step
        nearest = ends.min(axis=-1)
        if len(self.walls):
            here, along = origins[:, None, None], step[:, :, None]
            first, second = (self.walls[:, :2] - here) / along, (self.walls[:, 2:] - here) / along
            enter = np.minimum(first, second).max(axis=-1)
            leave = np.maximum(first, second).min(axis=-1)
            hit = (enter < leave) & (leave > 0.0)
            nearest = np.minimum(nearest, np.where(hit, np.maximum(enter, 0.0), np.inf).min(axis=-1))
        found: Floats = np.maximum(nearest, 0.0)
        return found

    def _corners(self) -> Floats:
        """(C, 2) the corners of the grown walls where a robot can be."""
        low, high = self.walls[:, :2] - _CORNER, self.walls[:, 2:] + _CORNER
        sides = np.stack((low, high), axis=1)  # (R, 2, 2)
        points = np.stack([sides[:, [i, j], [0, 1]] for i in (0, 1) for j in (0, 1)], axis=1).reshape(-1, 2)
        free = np.abs(points).max(axis=-1, initial=0.0) <= ARENA_HALF - CLEARANCE
        free &= (_clear(self.walls.T[..., None], _columns(points, 1)) >= CLEARANCE).all(axis=0)
        found: Floats = points[free]
        return found

    def _beyond(self, target: Seen) -> Floats:
        """(T, P, C) the lengths of the ways from each corner to the targets: by way of a corner that each sees."""
        sighted = target.corners != np.inf
        last = np.argsort(~sighted, axis=-1, kind="stable")[..., : max(1, int(sighted.sum(axis=-1).max(initial=0)))]
        onward = np.take_along_axis(target.corners, last, axis=-1)
        through = self._to_corners[last]  # (T, P, S, C)
        through += onward[..., None]
        beyond: Floats = through.min(axis=-2)
        return beyond

    def _next(self, first: npt.NDArray[np.intp], target: Seen, beyond: Floats) -> Floats:
        """Where the way to the target leads after its first corner (T, P): the target or another corner, (T, P, 2).

        `beyond` (T, P, C) are the lengths of the ways from the corners to the target.
        """
        straight = np.take_along_axis(
            np.broadcast_to(target.corners, (*first.shape, len(self.corners))), first[..., None], axis=-1
        )[..., 0]
        step = self._edges[first] + beyond
        np.put_along_axis(step, first[..., None], np.inf, axis=-1)
        second = step.argmin(axis=-1)
        shorter = np.isfinite(straight)
        return np.where(shorter[..., None], np.broadcast_to(target.points, (*first.shape, 2)), self.corners[second])

    @staticmethod
    def _carrot(here: Floats, turn: Floats, after: Floats) -> Floats:
        """Vectors from points towards a turn; close to it, already towards what comes after it."""
        to_turn, on = turn - here, after - turn
        left = np.linalg.norm(to_turn, axis=-1, keepdims=True)
        length = np.linalg.norm(on, axis=-1, keepdims=True)
        ahead: Floats = to_turn + on / np.maximum(length, _TINY) * np.maximum(_TURN - left, 0.0)
        return ahead


def way_finder(map_spec: MapSpec) -> WayFinder:
    """The ways of a map, made once for all variants of it: a millisecond, with 64 walls up to fifty."""
    return _way_finder(map_spec.walls, map_spec.goals)


@lru_cache(maxsize=1024)
def _way_finder(walls: tuple[Rect, ...], goals: tuple[Rect, ...]) -> WayFinder:
    return WayFinder(walls, goals)


def _inner(goal: Rect) -> tuple[float, float, float, float]:
    """The part of a goal region to which ways lead."""
    across, up = (min(_INSIDE_GOAL, side / 2) for side in (goal.right - goal.left, goal.top - goal.bottom))
    return goal.left + across, goal.bottom + up, goal.right - across, goal.top - up


def _columns(points: Floats, axes: int) -> _Columns:
    """Points (..., 2) as two arrays with so many axes."""
    shape = *[1] * (axes + 1 - points.ndim), *points.shape[:-1]
    return _Columns(*(np.ascontiguousarray(points[..., axis]).reshape(shape) for axis in (0, 1)))


def _met(walls: Floats, here: _Columns, there: _Columns, step: _Columns) -> Flags:
    """(R, ...) which of the walls (4, R, ...) lines meet.

    One axis after the other and in place: numpy takes ten times as long on arrays of pairs of numbers.
    """
    margin = np.minimum(_clear(walls, here), _clear(walls, there))
    enter, leave = _within(walls[0] - margin, walls[2] + margin, here.x, step.x)
    enter_y, leave_y = _within(walls[1] - margin, walls[3] + margin, here.y, step.y)
    np.maximum(np.maximum(enter, enter_y, out=enter), 0.0, out=enter)
    np.minimum(np.minimum(leave, leave_y, out=leave), 1.0, out=leave)
    met: Flags = (enter < leave) & (margin > -0.5)
    return met


def _within(low: Floats, high: Floats, here: Floats, step: Floats) -> tuple[Floats, Floats]:
    """Where on their way lines come between two sides and leave them, in steps. The sides (R, ...) are overwritten."""
    for side in (low, high):
        np.divide(np.subtract(side, here, out=side), step, out=side)
    return np.minimum(low, high), np.maximum(low, high, out=high)


def _clear(walls: Floats, points: _Columns) -> Floats:
    """(R, ...) how far lines at a point keep from each wall: the clearance, or the point's own distance if less.

    Distances are along one axis, as walls are grown to rectangles. -1 inside a wall, which then blocks nothing.
    """
    apart = np.maximum(walls[0] - points.x, points.x - walls[2])
    np.maximum(apart, np.maximum(walls[1] - points.y, points.y - walls[3]), out=apart)
    return np.where(apart > 0.0, np.minimum(CLEARANCE, apart - 1e-6), -1.0)


def _ways(towards: Floats, lengths: Floats, straight: Flags) -> Ways:
    norms = np.linalg.norm(towards, axis=-1, keepdims=True)
    directions = np.where(norms > 1e-3, towards / np.maximum(norms, 1e-3), 0.0)
    return Ways(directions, np.minimum(lengths, FAR), straight)
