"""Walking with empty hands: distance fields over the floor and a driver that follows them."""

import math

import numpy as np
import numpy.typing as npt

from agents.scripted.driving import Command, best_move
from agents.scripted.lattice import UNREACHED, Field, Motion
from agents.scripted.terrain import AXIS, CELL, CELLS, Terrain, cell_of
from maps.spec import ROBOT_RADIUS
from world.state import Floats

WALKER = Motion(
    1, (tuple((dx, dy, 0, 2 if dx == 0 or dy == 0 else 3) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy),)
)
ROBOT = ((0.0, 0.0, ROBOT_RADIUS),)
_LOOK_AHEAD = 3  # doublings: the direction at a cell looks 2**3 cells down the way
_TURN_COST = 9.0  # quarter ticks per radian off the way
_SHUNNED = 3  # quarter ticks besides

Mask = npt.NDArray[np.bool_]


def walk_field(ground: Terrain, targets: list[tuple[float, float]], shunned: Mask | None = None) -> Field:
    """Cost-to-go on foot to the nearest of `targets` (those inside obstacles are moved to the nearest free cell).

    Steps on `shunned` cells (CELLS, CELLS) count more than double.
    """
    surcharge = None if shunned is None else np.where(shunned.ravel(), _SHUNNED, 0).astype(np.int16)
    field = Field(ground, ROBOT, WALKER, surcharge=surcharge)
    costs = np.full((1, CELLS, CELLS), UNREACHED, dtype=np.int16)
    for x, y in targets:
        row, column = nearest_free(field.free[0], x, y, within=9)
        costs[0, row, column] = 0
    field.seed(costs)
    field.search(4000)
    return field


def nearest_free(free: npt.NDArray[np.bool_], x: float, y: float, within: int = 5) -> tuple[int, int]:
    """Row and column of the free cell nearest to (x, y), or of (x, y) itself when there is none near."""
    row, column = cell_of(x, y)
    rows, columns = slice(max(row - within, 0), row + within + 1), slice(max(column - within, 0), column + within + 1)
    found = np.argwhere(free[rows, columns])
    if not len(found):
        return row, column
    found += np.array([rows.start, columns.start])
    gaps = np.hypot(AXIS[found[:, 0]] - y, AXIS[found[:, 1]] - x)
    best = found[int(np.argmin(gaps))]
    return int(best[0]), int(best[1])


def grid_of(field: Field) -> npt.NDArray[np.int16]:
    """A walker's field as (rows, columns)."""
    return field.cost.reshape(CELLS, CELLS)


def cost_at(field: Field, x: float, y: float) -> float:
    """Quarter ticks from (x, y); UNREACHED when there is no way."""
    row, column = nearest_free(grid_of(field) < UNREACHED, x, y, within=4)
    return float(grid_of(field)[row, column])


class Way:
    """A walking field with the direction to take at each cell."""

    def __init__(self, ground: Terrain, targets: list[tuple[float, float]], shunned: Mask | None = None) -> None:
        self.field = walk_field(ground, targets, shunned)
        self._smooth = np.minimum(grid_of(self.field).astype(np.float64), 2000.0)
        self._heading, self._near = _headings(_filled(self._smooth))

    def cost(self, x: float, y: float) -> float:
        """Quarter ticks from (x, y) to the target; UNREACHED when there is no way."""
        return cost_at(self.field, x, y)

    def costs(self, moves: Floats) -> Floats:
        """(K,) for short moves (K, HORIZON, 3): what is left at their end, turning included."""
        ends = moves[:, -1]
        left = _values(self._smooth, ends)
        rows = np.clip(np.rint((ends[:, 1] - AXIS[0]) / CELL).astype(np.int64), 0, CELLS - 1)
        columns = np.clip(np.rint((ends[:, 0] - AXIS[0]) / CELL).astype(np.int64), 0, CELLS - 1)
        off = np.abs((ends[:, 2] - self._heading[rows, columns] + math.pi) % (2 * math.pi) - math.pi)
        return left + np.where(self._near[rows, columns], 0.0, off * _TURN_COST)

    def path(self, x: float, y: float, length: int) -> Floats:
        """(n <= length, 2) the cells on the way from (x, y)."""
        grid = self._smooth
        row, column = nearest_free(grid < 2000.0, x, y)
        cells = [(row, column)]
        while len(cells) < length and grid[row, column] > 0:
            rows, columns = slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2)
            window = grid[rows, columns]
            step = np.unravel_index(int(np.argmin(window)), window.shape)
            following = (rows.start + int(step[0]), columns.start + int(step[1]))
            if grid[following] >= grid[row, column]:
                break
            row, column = following
            cells.append(following)
        indices = np.array(cells)
        return np.stack([AXIS[indices[:, 1]], AXIS[indices[:, 0]]], axis=1)


def _filled(cost: Floats) -> Floats:
    """Costs also a little way into obstacles, where contact may press a robot: the way out of there first."""
    for _ in range(3):
        padded = np.pad(cost, 1, constant_values=2000.0)
        lowest = np.minimum(padded[:-2], padded[2:])
        lowest = np.minimum(lowest, padded[1:-1])
        lowest = np.minimum(np.minimum(lowest[:, :-2], lowest[:, 2:]), lowest[:, 1:-1])
        cost = np.where(cost >= 2000.0, np.minimum(lowest + 5.0, 2000.0), cost)
    return cost


def _values(grid: Floats, poses: Floats) -> Floats:
    u, v = (poses[:, 0] - AXIS[0]) / CELL, (poses[:, 1] - AXIS[0]) / CELL
    i = np.clip(np.floor(u).astype(np.int64)[:, None] + np.arange(-1, 3), 0, CELLS - 1)
    j = np.clip(np.floor(v).astype(np.int64)[:, None] + np.arange(-1, 3), 0, CELLS - 1)
    gap = np.hypot((v[:, None] - j)[:, :, None], (u[:, None] - i)[:, None, :]) * 2.0
    total = grid[j[:, :, None], i[:, None, :]] + gap
    return np.asarray(total.reshape(len(poses), -1).min(axis=1))


def _headings(cost: Floats) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """For each cell the heading of the way ahead, and whether the target is so near that it does not matter."""
    padded = np.pad(cost, 1, constant_values=1e9)
    shifts = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
    around = np.stack([padded[1 + dy : 1 + dy + CELLS, 1 + dx : 1 + dx + CELLS] for dy, dx in shifts])
    step = np.argmin(around, axis=0).ravel()
    offsets = np.array([dy * CELLS + dx for dy, dx in shifts])
    following = np.arange(CELLS * CELLS) + offsets[step]
    for _ in range(_LOOK_AHEAD):
        following = following[following]
    here = np.arange(CELLS * CELLS)
    dx = (following % CELLS - here % CELLS).astype(np.float64)
    dy = (following // CELLS - here // CELLS).astype(np.float64)
    near = (np.hypot(dx, dy) < 1.5).reshape(CELLS, CELLS)
    return np.arctan2(-dx, dy).reshape(CELLS, CELLS), near


def walk(way: Way, pose: Floats, danger: Floats | None = None) -> Command:
    """The next command of a robot at `pose` (3,) on its way."""
    command, _ = best_move(pose, way.costs)
    return command
