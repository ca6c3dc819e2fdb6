"""The search for a cost-to-go: backwards from all goal poses at once, in slices, once for all who ask the same.

Two robots that carry one item plan alike, and so do players who look at the same item from the same side. Each of
them sees a search as far as its own slices have brought it, whoever has really done the work.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple
from weakref import WeakValueDictionary

import numpy as np
import numpy.typing as npt

from agents.scripted.geometry import Disc
from agents.scripted.lattice import UNREACHED, Cost, Index, Motion
from agents.scripted.terrain import CELL, CELLS, Terrain
from world.state import Floats

LEVELS_PER_SLICE = 64  # a few milliseconds
_SPREAD = 16  # buckets in the ring: above the dearest move
_rank = np.empty(32 * CELLS * CELLS, dtype=np.int32)  # scratch of `_distinct`, for up to 32 headings


class _Slice(NamedTuple):
    """What a slice of searching has changed."""

    poses: npt.NDArray[np.int32]  # half of the room: they are kept for long
    costs: Cost
    level: int
    done: bool


class Search:
    """The cost-to-go of one body on one terrain. Indices are flat over (heading, row, column)."""

    def __init__(self, ground: Terrain, discs: Sequence[Disc], motion: Motion, margin: float, starts: Cost) -> None:
        """`discs` in the body's frame keep a `margin` [u] from everything.

        `starts` (headings, CELLS, CELLS) says where to go: start costs, UNREACHED where it is no goal.
        """
        self._predecessors = _predecessors(motion)
        free = _free_poses(ground, tuple(discs), motion.headings, margin)
        self.starts: Cost = np.where(free, starts.ravel(), np.int16(UNREACHED))
        self._bar: Cost = np.where(free, self.starts, np.int16(-1))  # the cost to beat at each pose
        self._buckets: list[list[Index]] = [[] for _ in range(_SPREAD)]
        self._later: dict[int, list[Index]] = {}
        self._pushed: list[Index] = []
        self._slices: list[_Slice] = []
        self._level = self._put_off_starts()  # every cheaper pose is settled
        self._done = not self._later
        self.start = _Slice(np.empty(0, dtype=np.int32), np.empty(0, dtype=np.int16), self._level, self._done)

    def slice(self, number: int) -> _Slice:
        """What slice `number`, from 0 on, changes."""
        while len(self._slices) <= number:
            self._slices.append(self._search())
        return self._slices[number]

    def _put_off_starts(self) -> int:
        """Have the starts come up when the search gets to their cost; return the least."""
        (goals,) = np.nonzero(self.starts < UNREACHED)
        goals = goals[np.argsort(self.starts[goals], kind="stable")]
        levels, firsts = np.unique(self.starts[goals], return_index=True)
        groups = np.split(goals, firsts[1:])
        self._later = {level: [group] for level, group in zip(levels.tolist(), groups, strict=False)}
        return min(self._later, default=0)

    def _search(self) -> _Slice:
        for _ in range(LEVELS_PER_SLICE):
            if self._done:
                break
            self._expand_level()
        poses = np.concatenate([np.empty(0, dtype=np.int64), *self._pushed])
        self._pushed = []
        return _Slice(poses.astype(np.int32), self._bar.take(poses), self._level, self._done)

    def _expand_level(self) -> None:
        bucket = self._level % _SPREAD
        waiting = self._buckets[bucket] + self._later.pop(self._level, [])
        self._buckets[bucket] = []
        if waiting:
            frontier = waiting[0] if len(waiting) == 1 else np.concatenate(waiting)
            frontier = _distinct(frontier[self._bar.take(frontier) == self._level])
            if frontier.size:
                self._relax(frontier)
        elif not self._later and not any(self._buckets):
            self._done = True
        self._level += 1

    def _relax(self, frontier: Index) -> None:
        heading = frontier // (CELLS * CELLS)
        for price, offsets in self._predecessors:  # the cheapest last: it stays
            cost = self._level + price
            before = offsets.take(heading, axis=1) + frontier if offsets.shape[1] > 1 else offsets + frontier
            better = before[self._bar.take(before) > cost]
            if better.size:
                self._bar[better] = cost
                self._buckets[cost % _SPREAD].append(better)
                self._pushed.append(better)


_Asked = tuple[Terrain, tuple[Disc, ...], Motion, float, bytes, bytes]
_alive: WeakValueDictionary[_Asked, Search] = WeakValueDictionary()


def shared_search(ground: Terrain, discs: Sequence[Disc], motion: Motion, margin: float, starts: Cost) -> Search:
    """A `Search`; the one that somebody still has, when it has all the same arguments."""
    goals = np.flatnonzero(starts < UNREACHED)
    asked = (ground, tuple(discs), motion, margin, goals.tobytes(), starts.take(goals).tobytes())
    known = _alive.get(asked)
    if known is None:
        known = _alive[asked] = Search(ground, discs, motion, margin, starts)
    return known


class Field:
    """A search as far as one player has followed it."""

    def __init__(self, search: Search) -> None:
        self._search = search
        self._followed = 0
        self.cost: Cost = search.starts.copy()  # flat over (heading, row, column)
        self.level, self.done = search.start.level, search.start.done

    def search(self) -> None:
        """Go on for a slice."""
        found = self._search.slice(self._followed)
        self._followed += 1
        self.cost[found.poses] = found.costs
        self.level, self.done = found.level, found.done


def _distinct(indices: Index) -> Index:
    order = np.arange(indices.size, dtype=np.int32)
    _rank[indices] = order
    return np.asarray(indices[_rank.take(indices) == order])


@lru_cache(maxsize=4)
def _predecessors(motion: Motion) -> tuple[tuple[int, Index], ...]:
    """Prices, the highest first, with flat offsets (moves, headings) from a pose to where such moves came from.

    A move that a heading does not have has the offset 0; where all headings have the same ones they are (moves, 1).
    """
    plane = CELLS * CELLS
    table = []
    for price in sorted({cost for row in motion.moves for *_, cost in row}, reverse=True):
        offsets = np.zeros((len(motion.moves[0]), motion.headings), dtype=np.int64)
        for heading, row in enumerate(motion.moves):
            for number, (dx, dy, turn, cost) in enumerate(row):
                if cost == price:
                    before = (heading - turn) % motion.headings
                    offsets[number, heading] = (before - heading) * plane - (dy * CELLS + dx)
        offsets = offsets[offsets.any(axis=1)]
        table.append((price, offsets[:, :1] if (offsets == offsets[:, :1]).all() else offsets))
    return tuple(table)


@lru_cache(maxsize=48)
def _free_poses(ground: Terrain, discs: tuple[Disc, ...], headings: int, margin: float) -> npt.NDArray[np.bool_]:
    """Flat over (heading, row, column): whether every disc keeps its radius and the margin from everything."""
    free = np.ones((headings, CELLS, CELLS), dtype=np.bool_)
    longest = max(math.hypot(x, y) for x, y, _ in discs)
    pad = int(longest / CELL) + 2
    padded = np.pad(ground.clearance, pad, constant_values=-1.0)
    for x, y, radius in discs:
        if x == 0.0 and y == 0.0:
            free &= ground.clearance >= radius + margin
            continue
        for heading in range(headings):
            angle = heading * 2 * math.pi / headings
            dx = x * math.cos(angle) - y * math.sin(angle)
            dy = x * math.sin(angle) + y * math.cos(angle)
            free[heading] &= _shifted(padded, pad, dx / CELL, dy / CELL) >= radius + margin
    return free.ravel()


def _shifted(padded: Floats, pad: int, columns: float, rows: float) -> Floats:
    """The clearance seen from each grid point at a fixed offset, interpolated."""
    i, j = math.floor(columns), math.floor(rows)
    a, b = columns - i, rows - j
    left, top = pad + i, pad + j
    at = padded[top : top + CELLS + 1, left : left + CELLS + 1]
    across = at[:, :-1] * (1 - a) + at[:, 1:] * a
    return np.asarray(across[:-1] * (1 - b) + across[1:] * b)
