"""The grid of poses (x, y, heading) on which costs-to-go are computed, and lookups at poses between its points.

A body is a set of discs about a reference point. With `SOLO_MOTION` it moves like a robot (forward, backward, turn),
with `PAIR_MOTION` like two robots that hold one item (any direction, slow turns), with `DRAG_MOTION` likewise without
turns.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from movingout.agents.scripted.navigation.free_space import AXIS, CELL, CELLS, cell_of
from movingout.maps.spec import ARENA_HALF
from movingout.world.state import Floats

UNIT_PER_TICK = 4  # costs are in quarter ticks: one tick drives 0.06
_AROUND = np.arange(-1, 2)
_NEIGHBOURS = np.arange(-1, 3)[:, None]  # of a point, per axis

Cost = npt.NDArray[np.int16]
Index = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class MotionPrimitives:
    """The moves of a body, per heading: (cells in x, cells in y, headings turned, cost)."""

    headings: int  # a power of two
    moves: tuple[tuple[tuple[int, int, int, int], ...], ...]  # [heading][move]


def _carrier() -> MotionPrimitives:
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
    return MotionPrimitives(headings, tuple(tuple(row) for row in table))


_SLIDES = tuple((dx, dy, 0, 2 if dx == 0 or dy == 0 else 3) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy)
DRAG_MOTION = MotionPrimitives(1, (_SLIDES,))
SOLO_MOTION = _carrier()
PAIR_MOTION = MotionPrimitives(32, ((*_SLIDES, (0, 0, 1, 4), (0, 0, -1, 4)),) * 32)


def costs_at_poses(costs: Cost, motion: MotionPrimitives, poses: Floats) -> Floats:
    """(M,) cost-to-go [quarter ticks] at any poses (M, 3), by way of the best grid pose nearby.

    It is UNREACHED where no reached grid pose lies within two cells and headings.
    """
    u = (poses[:, 0] + ARENA_HALF) / CELL
    v = (poses[:, 1] + ARENA_HALF) / CELL
    i = _within_floor(np.floor(u).astype(np.int64) + _NEIGHBOURS)  # (4, M): contiguous in the poses
    j = _within_floor(np.floor(v).astype(np.int64) + _NEIGHBOURS)
    cells = (j * CELLS)[:, None] + i  # (4, 4, M)
    off = _detour(np.hypot((v - j)[:, None], u - i), 2.2, 14.0)
    if motion.headings == 1:
        return np.asarray((costs.take(cells) + off).reshape(-1, len(poses)).min(axis=0))
    w = poses[:, 2] / (2 * math.pi / motion.headings)
    k = np.floor(w).astype(np.int64) + _NEIGHBOURS
    plane = (k & (motion.headings - 1)) * (CELLS * CELLS)  # `%` for a power of two, but much faster
    poses_near = plane[:, None, None] + cells  # (4, 4, 4, M)
    best = (costs.take(poses_near).astype(np.float64) + off).reshape(len(_NEIGHBOURS), -1, len(poses)).min(axis=1)
    return np.asarray((best + _detour(np.abs(w - k), 3.0, 8.0)).min(axis=0))


def _within_floor(indices: Index) -> Index:
    return np.minimum(np.maximum(indices, 0), CELLS - 1)


def nearest_cost(costs: Cost, motion: MotionPrimitives, pose: Floats) -> float:
    """The cost at the grid pose nearest to a pose (3,)."""
    column = min(max(round((float(pose[0]) + ARENA_HALF) / CELL), 0), CELLS - 1)
    row = min(max(round((float(pose[1]) + ARENA_HALF) / CELL), 0), CELLS - 1)
    heading = round(float(pose[2]) / (2 * math.pi / motion.headings)) % motion.headings
    return float(costs.reshape(motion.headings, CELLS, CELLS)[heading, row, column])


def grid_pose(motion: MotionPrimitives, pose: Floats) -> tuple[float, float, float]:
    """The grid pose nearest to a pose (3,)."""
    step = 2 * math.pi / motion.headings
    row, column = cell_of(float(pose[0]), float(pose[1]))
    return float(AXIS[column]), float(AXIS[row]), round(float(pose[2]) / step) * step


def next_pose(costs: Cost, motion: MotionPrimitives, pose: Floats) -> tuple[float, float, float]:
    """The grid pose that follows, on the path to the goal, the reached grid pose nearest to a pose (3,)."""
    step = 2 * math.pi / motion.headings
    grid = costs.reshape(motion.headings, CELLS, CELLS)
    row, column = cell_of(float(pose[0]), float(pose[1]))
    heading = round(float(pose[2]) / step)
    rows, columns = np.clip(row + _AROUND, 0, CELLS - 1), np.clip(column + _AROUND, 0, CELLS - 1)
    headings = heading + _AROUND
    off = np.hypot(AXIS[rows, None] - pose[1], AXIS[columns] - pose[0]) / CELL
    turn = np.abs(headings * step - pose[2]) / step
    near = grid[np.ix_(headings % motion.headings, rows, columns)]
    total = near + _detour(off, 2.2, 14.0) + _detour(turn, 3.0, 8.0)[:, None, None]
    k, j, i = np.unravel_index(int(np.argmin(total)), total.shape)
    heading, row, column = int(headings[k]), int(rows[j]), int(columns[i])
    best = (float(near[k, j, i]), column, row, heading)
    for dx, dy, turned, cost in motion.moves[heading % motion.headings]:
        there = (heading + turned) % motion.headings, row + dy, column + dx
        if 0 <= there[1] < CELLS and 0 <= there[2] < CELLS and grid[there] + cost <= best[0]:
            best = (float(grid[there]), there[2], there[1], heading + turned)
    return float(AXIS[best[1]]), float(AXIS[best[2]]), best[3] * step


def _detour(distance: Floats, near: float, far: float) -> Floats:
    """The cost of being off a grid pose: low within a step, high beyond, where there may be an obstacle."""
    return distance * near + np.maximum(distance - 0.9, 0.0) * far
