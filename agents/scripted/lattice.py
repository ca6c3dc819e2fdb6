"""Cost-to-go over poses: how many quarter ticks a rigid body needs from any (x, y, heading) to its goal.

A body is a set of discs about a reference point. `CARRIER` moves like a robot (ahead, back, turn); `PAIR` like two
robots holding one item between them (any direction, slow turns), `SLIDER` likewise without turns. The search runs
backwards from all goal poses at once, in buckets of equal cost, and can be cut into slices so that no decision takes
long.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from agents.scripted.geometry import Disc
from agents.scripted.terrain import CELL, CELLS, Terrain
from maps.spec import ARENA_HALF
from world.state import Floats

UNIT_PER_TICK = 4  # costs are in quarter ticks: one tick drives 0.06
UNREACHED = 30000
_NEIGHBOURS = np.arange(-1, 3)  # of a point, per axis
_SPREAD = 16  # buckets in the ring: above the dearest move

Cost = npt.NDArray[np.int16]
Index = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Motion:
    """What moves a body has: per heading, (cells in x, cells in y, headings turned, cost)."""

    headings: int
    moves: tuple[tuple[tuple[int, int, int, int], ...], ...]  # [heading][move]


def _carrier() -> Motion:
    headings = 16
    table = []
    for heading in range(headings):
        angle = heading * 2 * math.pi / headings
        dx, dy = -math.sin(angle), math.cos(angle)
        largest = max(abs(dx), abs(dy))
        if heading % 4 == 2:
            step = (round(dx / largest), round(dy / largest))
        else:
            step = (round(2 * dx), round(2 * dy)) if heading % 4 == 0 else (round(1.8 * dx), round(1.8 * dy))
        cost = max(round(math.hypot(*step) * CELL / 0.06 * UNIT_PER_TICK), 1)
        turns = [(0, 0, sign, 2) for sign in (1, -1)]
        table.append(((*step, 0, cost), (-step[0], -step[1], 0, cost), *turns))
    return Motion(headings, tuple(tuple(row) for row in table))


_SLIDES = tuple((dx, dy, 0, 2 if dx == 0 or dy == 0 else 3) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy)
SLIDER = Motion(1, (_SLIDES,))
CARRIER = _carrier()
PAIR = Motion(32, ((*_SLIDES, (0, 0, 1, 4), (0, 0, -1, 4)),) * 32)


class Field:
    """The cost-to-go of one body on one terrain. Indices are flat over (heading, row, column)."""

    def __init__(
        self,
        ground: Terrain,
        discs: Sequence[Disc],
        motion: Motion,
        margin: float,
    ) -> None:
        """`discs` in the body's frame keep a `margin` [u] from everything."""
        self.motion = motion
        self._free = _free_poses(ground, tuple(discs), motion.headings, margin)
        self._bar: Cost = np.where(self._free, np.int16(UNREACHED), np.int16(-1))  # the cost to beat at each pose
        self.cost: Cost = np.full(self._free.size, UNREACHED, dtype=np.int16)  # after the last `search`
        self._buckets: list[list[Index]] = [[] for _ in range(_SPREAD)]
        self._later: dict[int, list[Index]] = {}
        self.level = 0  # every cheaper pose is settled
        self._tag = np.empty(self._free.size, dtype=np.int32)
        self.done = False

    @property
    def free(self) -> npt.NDArray[np.bool_]:
        """(headings, CELLS, CELLS) whether the body fits."""
        return self._free.reshape(self.motion.headings, CELLS, CELLS)

    def seed(self, costs: Cost) -> None:
        """Set where to go: (headings, CELLS, CELLS) start costs, UNREACHED where it is no goal."""
        flat = costs.ravel()
        (goals,) = np.nonzero((flat < UNREACHED) & self._free)
        self.cost[goals] = self._bar[goals] = flat[goals]
        order = np.argsort(flat[goals], kind="stable")
        goals = goals[order]
        levels, starts = np.unique(flat[goals], return_index=True)
        if not levels.size:
            self.done = True
            return
        for level, group in zip(levels.tolist(), np.split(goals, starts[1:]), strict=True):
            self._later[level] = [group]
        self.level = int(levels[0])

    def search(self, levels: int) -> None:
        """Go on for this many levels of cost."""
        for _ in range(levels):
            if self.done:
                break
            self._expand_level()
        np.copyto(self.cost, self._bar, where=self._free)

    def _expand_level(self) -> None:
        bucket = self.level % _SPREAD
        waiting = self._buckets[bucket] + self._later.pop(self.level, [])
        self._buckets[bucket] = []
        if waiting:
            frontier = waiting[0] if len(waiting) == 1 else np.concatenate(waiting)
            frontier = self._distinct(frontier[self._bar.take(frontier) == self.level])
            if frontier.size:
                self._relax(frontier)
        elif not self._later and not any(self._buckets):
            self.done = True
        self.level += 1

    def _relax(self, frontier: Index) -> None:
        heading = frontier // (CELLS * CELLS) if self.motion.headings > 1 else frontier
        for price, offsets in _predecessors(self.motion):  # the cheapest last: it stays
            cost = self.level + price
            before = offsets.take(heading, axis=1) + frontier if offsets.shape[1] > 1 else offsets + frontier
            better = before[self._bar.take(before) > cost]
            if better.size:
                self._bar[better] = cost
                self._buckets[cost % _SPREAD].append(better)

    def _distinct(self, indices: Index) -> Index:
        order = np.arange(indices.size, dtype=np.int32)
        self._tag[indices] = order
        return np.asarray(indices[self._tag.take(indices) == order])


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


@lru_cache(maxsize=16)
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


def values(costs: Cost, motion: Motion, poses: Floats) -> Floats:
    """(M,) cost-to-go [quarter ticks] at any poses (M, 3): the best way over a lattice pose nearby.

    Poses from which nothing reached lies within two cells and headings have the value UNREACHED.
    """
    u = (poses[:, 0] + ARENA_HALF) / CELL
    v = (poses[:, 1] + ARENA_HALF) / CELL
    i = _within_floor(np.floor(u).astype(np.int64)[:, None] + _NEIGHBOURS)
    j = _within_floor(np.floor(v).astype(np.int64)[:, None] + _NEIGHBOURS)
    cells = j[:, :, None] * CELLS + i[:, None, :]
    gap = np.hypot((v[:, None] - j)[:, :, None], (u[:, None] - i)[:, None, :])
    off = _detour(gap, 2.2, 14.0)  # (M, 4, 4)
    if motion.headings == 1:
        return np.asarray((costs[cells] + off).reshape(len(poses), -1).min(axis=1))
    w = poses[:, 2] / (2 * math.pi / motion.headings)
    k = np.floor(w).astype(np.int64)[:, None] + _NEIGHBOURS
    poses_near = (k % motion.headings * (CELLS * CELLS))[:, :, None, None] + cells[:, None]
    best = (costs.take(poses_near) + off[:, None]).reshape(len(poses), len(_NEIGHBOURS), -1).min(axis=2)
    return np.asarray((best + _detour(np.abs(w[:, None] - k), 3.0, 8.0)).min(axis=1))


def _within_floor(indices: Index) -> Index:
    return np.minimum(np.maximum(indices, 0), CELLS - 1)


def nearest_value(costs: Cost, motion: Motion, pose: Floats) -> float:
    """The cost at the lattice pose nearest to a pose (3,)."""
    column = min(max(round((float(pose[0]) + ARENA_HALF) / CELL), 0), CELLS - 1)
    row = min(max(round((float(pose[1]) + ARENA_HALF) / CELL), 0), CELLS - 1)
    heading = round(float(pose[2]) / (2 * math.pi / motion.headings)) % motion.headings
    return float(costs.reshape(motion.headings, CELLS, CELLS)[heading, row, column])


def _detour(distance: Floats, near: float, far: float) -> Floats:
    """The price of being off a lattice pose: low within a step, high beyond, where there may be something."""
    return distance * near + np.maximum(distance - 0.9, 0.0) * far
