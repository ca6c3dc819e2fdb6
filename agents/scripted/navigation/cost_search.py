"""The search for a cost-to-go: backwards from all goal poses at once, in slices, shared by equal requests.

Two robots that carry an item make the same plan, as do agents that consider the same item from the same side. Each sees
a search only as far as its own slices reach, whichever of them did the work.
"""

import math
from collections import deque
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from movingout.agents.scripted.navigation.free_space import CELL, CELLS, FreeSpace
from movingout.agents.scripted.navigation.geometry import Disc
from movingout.agents.scripted.navigation.pose_grid import Cost, Index, MotionPrimitives
from movingout.maps.flood_fill import UNREACHED
from movingout.world.state import Floats

LEVELS_PER_SLICE = 64  # a few milliseconds
_STEP = 2  # levels expanded at once: no move is cheaper, so no pose of these leads to another
_DEAREST = 4  # the highest cost of a move
_rank = np.empty(32 * CELLS * CELLS, dtype=np.int32)  # scratch of `Search._unsettled`, for up to 32 headings


class _Slice(NamedTuple):
    """The changes made by one slice of a search."""

    poses: npt.NDArray[np.int32]  # int32, as they are kept for long
    costs: Cost
    level: int
    done: bool


class Search:
    """The cost-to-go of one body in one free space. Indices are flat over (heading, row, column)."""

    def __init__(
        self, space: FreeSpace, discs: Sequence[Disc], motion: MotionPrimitives, margin: float, starts: Cost
    ) -> None:
        """`discs`, in the body's frame, keep a `margin` [u] from obstacles.

        `starts` (headings, CELLS, CELLS): the cost of each goal pose, UNREACHED for all others.
        """
        self._moves = _moves_back(motion)
        free = _free_poses(space, discs, motion.headings, margin)
        goals = np.flatnonzero(free & (starts.ravel() < UNREACHED))
        self.starts: Cost = np.full(free.shape, UNREACHED, dtype=np.int16)
        self.starts[goals] = starts.take(goals)
        self._bar: Cost = self.starts | (free.view(np.int8) - np.int8(1))  # the cost to beat at each pose, or -1
        self._soon: list[Index] = []  # poses of the next step
        self._then: list[Index] = []  # and of the step after it
        self._later: dict[int, Index] = {}  # goal poses, by the level of their step
        self._recent: deque[Index] = deque(maxlen=_DEAREST + 1)  # the poses settled in the last steps
        self._slices: list[_Slice] = []
        self._level, self._last = self._put_off_starts(goals)  # settled below; highest offer so far
        self._exhausted = False
        self._done = not self._later
        self.start = _Slice(np.empty(0, dtype=np.int32), np.empty(0, dtype=np.int16), self._level, self._done)

    def slice(self, number: int) -> _Slice:
        """The changes of slice `number`, counted from 0."""
        while len(self._slices) <= number:
            self._slices.append(self._search())
        return self._slices[number]

    def _put_off_starts(self, goals: Index) -> tuple[int, int]:
        """Schedule the goal poses by cost; return the lowest and the highest cost."""
        if not goals.size:
            return 0, 0
        costs = self.starts.take(goals)
        least, highest = int(costs.min()), int(costs.max())
        steps = (costs - least) // _STEP
        goals = goals[np.argsort(steps, kind="stable")]
        end = np.bincount(steps).cumsum().tolist()
        for number, (first, last) in enumerate(zip([0, *end], end, strict=False)):
            if last > first:
                self._later[least + _STEP * number] = goals[first:last]
        return least, highest

    def _search(self) -> _Slice:
        end = self._level + LEVELS_PER_SLICE
        settled: list[Index] = []
        while self._level < end and (self._soon or self._then or self._later):
            settled.append(self._expand())
            self._level += _STEP
        if not (self._exhausted or self._soon or self._then or self._later):
            self._last, self._exhausted = self._dearest_offer(), True
        self._done = self._exhausted and self._last + 1 < end  # true from the first level without pending poses
        self._level = self._last + 2 if self._done else end
        poses = np.concatenate([*settled, *self._soon, *self._then]) if settled else np.empty(0, dtype=np.int64)
        return _Slice(poses.astype(np.int32), self._bar.take(poses), self._level, self._done)

    def _expand(self) -> Index:
        """Make the next step; returns the poses that it settles."""
        waiting = self._soon
        if self._level in self._later:
            waiting = [*waiting, self._later.pop(self._level)]
        self._soon, self._then = self._then, []
        if not waiting:
            return np.empty(0, dtype=np.int64)
        frontier = self._unsettled(waiting[0] if len(waiting) == 1 else np.concatenate(waiting))
        if frontier.size:
            self._recent.append(frontier)
            before, costs = self._relax(frontier)
            near = costs < self._level + 2 * _STEP
            for group, chosen in ((self._soon, near), (self._then, ~near)):
                poses = before.take(chosen.nonzero()[0])
                if poses.size:
                    group.append(poses)
        return frontier

    def _unsettled(self, poses: Index) -> Index:
        """The distinct poses whose cost lies in the coming step."""
        order = np.arange(poses.size, dtype=np.int32)
        _rank[poses] = order
        wanted = _rank.take(poses) == order
        wanted &= self._bar.take(poses) >= self._level
        return np.asarray(poses.take(wanted.nonzero()[0]))

    def _relax(self, frontier: Index) -> tuple[Index, Cost]:
        """Relax the moves that lead to the frontier; returns the poses that improved and the costs offered."""
        alike, distinct_grasps, prices = self._moves
        heading = frontier // (CELLS * CELLS)
        sources = np.empty((len(alike) + len(distinct_grasps), frontier.size), dtype=np.int64)
        np.add(alike, frontier, out=sources[: len(alike)])
        np.add(distinct_grasps.take(heading, axis=1), frontier, out=sources[len(alike) :])
        offers = (prices if prices.shape[1] == 1 else prices.take(heading, axis=1)) + self._bar.take(frontier)
        better = (self._bar.take(sources) > offers).ravel().nonzero()[0]
        before, costs = sources.take(better), offers.take(better)
        np.minimum.at(self._bar, before, costs)
        return before, costs

    def _dearest_offer(self) -> int:
        """The highest cost that would have been offered if each level had been expanded alone.

        It determines when the search is done. Expanding two levels at once also makes offers from the upper level that
        the lower one has just bettered, so the last levels are expanded again, one by one.
        """
        poses = np.concatenate(self._recent)
        costs = self._bar.take(poses)
        end = int(costs.max())
        if end + _DEAREST <= self._last:
            return self._last
        new = poses[costs > end - _DEAREST]
        self._bar[new] = self.starts[new]
        dearest = max(end, self._last)
        for level in range(end - 2 * _DEAREST + 1, end + 1):
            _, offers = self._relax(poses[costs == level])
            dearest = max(dearest, int(offers.max(initial=0)))
        return dearest


_Asked = tuple[FreeSpace, tuple[Disc, ...], MotionPrimitives, float, bytes, bytes]
_alive: WeakValueDictionary[_Asked, Search] = WeakValueDictionary()


def shared_search(
    space: FreeSpace, discs: Sequence[Disc], motion: MotionPrimitives, margin: float, starts: Cost
) -> Search:
    """A `Search`, shared with any user that still holds one of equal arguments."""
    goals = np.flatnonzero(starts < UNREACHED)
    asked = (space, tuple(discs), motion, margin, goals.tobytes(), starts.take(goals).tobytes())
    known = _alive.get(asked)
    if known is None:
        known = _alive[asked] = Search(space, discs, motion, margin, starts)
    return known


class CostToGo:
    """The result of a search as far as one agent has followed it."""

    def __init__(self, search: Search) -> None:
        self._search = search
        self._followed = 0
        self.cost: Cost = search.starts.copy()  # flat over (heading, row, column)
        self.level, self.done = search.start.level, search.start.done

    def search(self) -> None:
        """Follow the search for another slice."""
        found = self._search.slice(self._followed)
        self._followed += 1
        self.cost[found.poses] = found.costs
        self.level, self.done = found.level, found.done


@lru_cache(maxsize=4)
def _moves_back(motion: MotionPrimitives) -> tuple[Index, Index, Cost]:
    """Flat offsets from a pose to its predecessors, and the costs of these moves.

    First the offsets that are equal for all headings (moves, 1), then the others (moves, headings); the costs are in
    the same order, (moves, 1) if they are equal for all headings.
    """
    plane = CELLS * CELLS
    table = np.array(motion.moves)  # (headings, moves, 4)
    heading = np.arange(motion.headings)[:, None]
    before = (heading - table[..., 2]) % motion.headings
    offsets = ((before - heading) * plane - (table[..., 1] * CELLS + table[..., 0])).T
    prices = table[..., 3].T.astype(np.int16)
    alike = (offsets == offsets[:, :1]).all(axis=1)
    prices = np.concatenate([prices[alike], prices[~alike]])
    assert _STEP <= int(prices.min()) <= int(prices.max()) <= _DEAREST
    return offsets[alike, :1], offsets[~alike], prices[:, :1] if (prices == prices[:, :1]).all() else prices


def _free_poses(space: FreeSpace, discs: Sequence[Disc], headings: int, margin: float) -> npt.NDArray[np.bool_]:
    """Flat over (heading, row, column): whether every disc keeps the margin from obstacles."""
    free = np.bitwise_and.reduce([_room_for(space, disc, headings, margin) for disc in discs])
    return np.unpackbits(free, count=headings * CELLS * CELLS).view(np.bool_)


@lru_cache(maxsize=64)  # grasps of an item differ in a few discs only
def _room_for(space: FreeSpace, disc: Disc, headings: int, margin: float) -> npt.NDArray[np.uint8]:
    """The same for one disc, as packed bits."""
    x, y, radius = disc
    room = np.empty((headings, CELLS, CELLS), dtype=np.bool_)
    if x == 0.0 and y == 0.0:
        room[:] = space.clearance >= radius + margin
        return np.packbits(room)
    pad = int(math.hypot(x, y) / CELL) + 2
    padded = np.pad(space.clearance, pad, constant_values=-1.0)
    for heading in range(headings):
        angle = heading * 2 * math.pi / headings
        dx = x * math.cos(angle) - y * math.sin(angle)
        dy = x * math.sin(angle) + y * math.cos(angle)
        np.greater_equal(_shifted(padded, pad, dx / CELL, dy / CELL), radius + margin, out=room[heading])
    return np.packbits(room)


def _shifted(padded: Floats, pad: int, columns: float, rows: float) -> Floats:
    """The clearance at a fixed offset from each grid point, interpolated."""
    i, j = math.floor(columns), math.floor(rows)
    a, b = columns - i, rows - j
    left, top = pad + i, pad + j
    at = padded[top : top + CELLS + 1, left : left + CELLS + 1]
    across = at[:, :-1] * (1 - a)
    across += at[:, 1:] * a
    seen = across[:-1] * (1 - b)
    seen += across[1:] * b
    return np.asarray(seen)
