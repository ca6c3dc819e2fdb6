"""Cost-to-go over poses: how many quarter ticks a rigid body needs from any (x, y, heading) to its goal.

A body is a set of discs about a reference point. `CARRIER` moves like a robot (ahead, back, turn); `PAIR` like two
robots holding one item between them (any direction, slow turns). The search runs backwards from all goal poses at
once, in buckets of equal cost, and can be cut into slices so that no decision takes long.
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


def _pair() -> Motion:
    headings = 32
    slides = [(dx, dy, 0, 2 if dx == 0 or dy == 0 else 3) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy]
    row = (*slides, (0, 0, 1, 4), (0, 0, -1, 4))
    return Motion(headings, (row,) * headings)


CARRIER = _carrier()
PAIR = _pair()


class Field:
    """The cost-to-go of one body on one terrain. Indices are flat over (heading, row, column)."""

    def __init__(
        self,
        ground: Terrain,
        discs: Sequence[Disc],
        motion: Motion,
        margin: float = 0.004,
        surcharge: Cost | None = None,
    ) -> None:
        """`surcharge` (flat like the poses, small numbers) is paid besides for each move from a pose."""
        self.motion = motion
        self._surcharge = surcharge
        self._free = _free_poses(ground, discs, motion.headings, margin)
        self.cost: Cost = np.full(self._free.size, UNREACHED, dtype=np.int16)
        self._bar: Cost = np.where(self._free, np.int16(UNREACHED), np.int16(-1))  # the cost to beat at each pose
        self._buckets: list[list[Index]] = [[] for _ in range(_SPREAD)]
        self._later: dict[int, list[Index]] = {}
        self.level = 0  # every cheaper pose is settled
        self._tag = np.zeros(self._free.size, dtype=np.int64)
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
                return
            self._expand_level()

    def _expand_level(self) -> None:
        waiting = self._buckets[self.level % _SPREAD] + self._later.pop(self.level, [])
        self._buckets[self.level % _SPREAD] = []
        if waiting:
            frontier = np.concatenate(waiting)
            frontier = self._distinct(frontier[self.cost[frontier] == self.level])
            if frontier.size:
                self._relax(frontier)
        elif not self._later and not any(self._buckets):
            self.done = True
        self.level += 1

    def _relax(self, frontier: Index) -> None:
        offsets, prices = _predecessors(self.motion)
        heading = frontier // (CELLS * CELLS)
        before = (frontier[:, None] + offsets.take(heading, axis=0)).ravel()  # (poses x moves,)
        cost = (prices.take(heading, axis=0) + np.int16(self.level)).ravel()
        if self._surcharge is not None:
            cost = cost + self._surcharge.take(before)
        better = self._bar.take(before) > cost
        before, cost = before[better], cost[better]
        for value in sorted(set(cost.tolist()), reverse=True):  # the cheapest last: it stays
            group = before[cost == value]
            self._bar[group] = value
            self.cost[group] = value
            self._buckets[value % _SPREAD].append(group)

    def _distinct(self, indices: Index) -> Index:
        self._tag[indices] = np.arange(indices.size)
        return np.asarray(indices[self._tag[indices] == np.arange(indices.size)])


@lru_cache(maxsize=4)
def _predecessors(motion: Motion) -> tuple[Index, Cost]:
    """Flat offsets (headings, moves) from a pose to where each move came from, and what the moves cost."""
    plane = CELLS * CELLS
    offsets = np.zeros((motion.headings, len(motion.moves[0])), dtype=np.int64)
    prices = np.zeros(offsets.shape, dtype=np.int16)
    for heading, row in enumerate(motion.moves):
        for number, (dx, dy, turn, cost) in enumerate(row):
            before = (heading - turn) % motion.headings
            offsets[heading, number] = (before - heading) * plane - (dy * CELLS + dx)
            prices[heading, number] = cost
    return offsets, prices


def _free_poses(ground: Terrain, discs: Sequence[Disc], headings: int, margin: float) -> npt.NDArray[np.bool_]:
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
    step = 2 * math.pi / motion.headings
    u = (poses[:, 0] + ARENA_HALF) / CELL
    v = (poses[:, 1] + ARENA_HALF) / CELL
    w = poses[:, 2] / step
    near = np.arange(-1, 3) if motion.headings > 1 else np.zeros(1, dtype=np.int64)
    i = np.clip(np.floor(u).astype(np.int64)[:, None] + np.arange(-1, 3), 0, CELLS - 1)
    j = np.clip(np.floor(v).astype(np.int64)[:, None] + np.arange(-1, 3), 0, CELLS - 1)
    k = np.floor(w).astype(np.int64)[:, None] + near
    flat = (k % motion.headings)[:, :, None, None] * (CELLS * CELLS) + j[:, None, :, None] * CELLS + i[:, None, None, :]
    gap = np.hypot((v[:, None] - j)[:, :, None], (u[:, None] - i)[:, None, :])[:, None]
    turn = np.abs(w[:, None] - k)[:, :, None, None] if motion.headings > 1 else np.zeros(1)
    total = costs.reshape(-1)[flat] + _detour(gap, 2.2, 14.0) + _detour(turn, 3.0, 8.0)
    return np.asarray(total.reshape(len(poses), -1).min(axis=1))


def nearest_value(costs: Cost, motion: Motion, pose: Floats) -> float:
    """The cost at the lattice pose nearest to a pose (3,)."""
    column = min(max(round((float(pose[0]) + ARENA_HALF) / CELL), 0), CELLS - 1)
    row = min(max(round((float(pose[1]) + ARENA_HALF) / CELL), 0), CELLS - 1)
    heading = round(float(pose[2]) / (2 * math.pi / motion.headings)) % motion.headings
    return float(costs.reshape(motion.headings, CELLS, CELLS)[heading, row, column])


def _detour(distance: Floats, near: float, far: float) -> Floats:
    """The price of being off a lattice pose: low within a step, high beyond, where there may be something."""
    return distance * near + np.maximum(distance - 0.9, 0.0) * far
