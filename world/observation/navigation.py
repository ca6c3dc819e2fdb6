"""Shortest ways between any two points of a map, from all pairs of coarse cells, computed once per map.

The arena is cut into 24 x 24 cells of 0.1, linked to their 8 neighbours. Walls block cells; cells beside a wall cost
more, so that ways keep a robot's radius from corners. Items are not obstacles here.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec, Rect
from movingout.maps.spec import ARENA_HALF
from movingout.world.state import Floats

CELLS = 24
CELL = 2 * ARENA_HALF / CELLS
BESIDE_WALL_COST = 2.0  # how much longer a cell beside a wall counts
FAR = 20.0  # [u] length where there is no way; the longest way on the twelve maps is under 10
LOOK_AHEAD = 3  # cells along the way to which a direction points
STRAIGHT = 1.09  # a way at most this much longer than the bird's is walked straight (8 directions cost up to 8 %)
_STEPS = tuple((dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy)

_Indices = npt.NDArray[np.intp]


class GridPoints(NamedTuple):
    """Points (..., 2) and the cells (...) in which they lie, looked up once for all ways that begin or end there."""

    points: Floats
    cells: _Indices


class Navigation:
    """Lookups of ways on one map."""

    def __init__(self, walls: tuple[Rect, ...], goals: tuple[Rect, ...]) -> None:
        blocked = _blocked(walls)
        self._lengths = _all_pairs(blocked)
        self._next = _next_cells(self._lengths, blocked)
        columns, rows = np.divmod(np.arange(CELLS * CELLS), CELLS)
        self._centres = np.stack((columns, rows), axis=1) * CELL + CELL / 2 - ARENA_HALF
        goal = _cells(np.array([((g.x0 + g.x1) / 2, (g.y0 + g.y1) / 2) for g in goals]))
        self._goal_cells = goal
        self._goal_points = self._centres[goal]

    def ways(self, start: GridPoints, target: GridPoints) -> tuple[Floats, Floats]:
        """From points to points around the walls.

        Unit vectors (..., 2) that lead there, zeros at the target, and lengths [u] (...); `FAR` where there is no way.
        """
        coarse = self._lengths[start.cells, target.cells]
        beeline = target.points - start.points
        straight = np.linalg.norm(beeline, axis=-1)
        lengths = np.where(coarse <= STRAIGHT * straight + 2 * CELL, straight, coarse)
        ahead = start.cells
        for _ in range(LOOK_AHEAD):
            ahead = self._next[ahead, target.cells]
        direct = coarse <= STRAIGHT * straight + CELL
        towards = np.where(direct[..., None], beeline, self._centres[ahead] - start.points)
        norms = np.linalg.norm(towards, axis=-1, keepdims=True)
        unit: Floats = towards / np.maximum(norms, 1e-6)
        return np.where(norms > 1e-3, unit, 0.0), lengths

    def nearest_goal(self, of: GridPoints) -> GridPoints:
        """The centres of the goals nearest by way to points."""
        nearest = self._lengths[of.cells[..., None], self._goal_cells].argmin(axis=-1)
        return GridPoints(self._goal_points[nearest], self._goal_cells[nearest])


def navigation(map_spec: MapSpec) -> Navigation:
    """The navigation of a map, made once for all variants of it (0.2 s)."""
    return _navigation(map_spec.walls, map_spec.goals)


@lru_cache(maxsize=64)
def _navigation(walls: tuple[Rect, ...], goals: tuple[Rect, ...]) -> Navigation:
    return Navigation(walls, goals)


def on_grid(points: Floats) -> GridPoints:
    """Points (..., 2) and where they lie, on any map."""
    return GridPoints(points, _cells(points))


def _cells(points: Floats) -> _Indices:
    indices = np.clip((points + ARENA_HALF) / CELL, 0, CELLS - 1).astype(np.intp)
    cells: _Indices = indices[..., 0] * CELLS + indices[..., 1]
    return cells


def _blocked(walls: tuple[Rect, ...]) -> npt.NDArray[np.bool_]:
    """(24, 24) [column, row]: cells whose centre a wall covers or nearly covers."""
    centres = (np.arange(CELLS) + 0.5) * CELL - ARENA_HALF
    mask = np.zeros((CELLS, CELLS), dtype=np.bool_)
    margin = 0.4 * CELL
    for wall in walls:
        columns = (centres > wall.left - margin) & (centres < wall.right + margin)
        rows = (centres > wall.bottom - margin) & (centres < wall.top + margin)
        mask |= columns[:, None] & rows[None, :]
    return mask


def _all_pairs(blocked: npt.NDArray[np.bool_]) -> Floats:
    """(576, 576) way lengths by Floyd and Warshall; a blocked cell can be left but not crossed."""
    count = CELLS * CELLS
    costs = 1.0 + (BESIDE_WALL_COST - 1.0) * (_grown(blocked) & ~blocked)
    lengths = np.full((count, count), FAR, dtype=np.float32)
    np.fill_diagonal(lengths, 0.0)
    for dx, dy in _STEPS:
        for column in range(max(0, -dx), min(CELLS, CELLS - dx)):
            rows = np.arange(max(0, -dy), min(CELLS, CELLS - dy))
            here, there = column * CELLS + rows, (column + dx) * CELLS + rows + dy
            step = CELL * np.hypot(dx, dy) * (costs[column, rows] + costs[column + dx, rows + dy]) / 2
            lengths[here, there] = step
    for middle in np.flatnonzero(~blocked.ravel()):
        np.minimum(lengths, lengths[:, middle, None] + lengths[None, middle], out=lengths)
    return lengths.astype(np.float64)


def _next_cells(lengths: Floats, blocked: npt.NDArray[np.bool_]) -> _Indices:
    """(576, 576) the neighbour through which the way from a cell to a cell leads; itself at the end."""
    count = CELLS * CELLS
    best = np.full((count, count), np.inf)
    choice = np.tile(np.arange(count)[:, None], (1, count))
    columns, rows = np.divmod(np.arange(count), CELLS)
    for dx, dy in _STEPS:
        inside = (columns + dx >= 0) & (columns + dx < CELLS) & (rows + dy >= 0) & (rows + dy < CELLS)
        here = np.flatnonzero(inside)
        there = here + dx * CELLS + dy
        through = lengths[here, there][:, None] + lengths[there]
        through[blocked.ravel()[there]] = np.inf
        better = through < best[here] - 1e-6
        best[here] = np.where(better, through, best[here])
        choice[here] = np.where(better, there[:, None], choice[here])
    np.fill_diagonal(choice, np.arange(count))
    return choice


def _grown(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    padded = np.pad(mask, 1)
    grown: npt.NDArray[np.bool_] = np.logical_or.reduce(
        [padded[1 + dx : 1 + dx + CELLS, 1 + dy : 1 + dy + CELLS] for dx, dy in (*_STEPS, (0, 0))]
    )
    return grown
