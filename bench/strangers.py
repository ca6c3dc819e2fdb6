"""Four plain partners that nothing is tuned with or trained on: `match --red bench.strangers:Near --blue scripted`.

They share no code with the agents: coarse breadth-first walks, straight drives where the view is free, no packing, no
handing over. They exist to measure how an agent plays with somebody of another make.
"""

import math
from collections import deque

import numpy as np
import numpy.typing as npt

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.maps import MapSpec
from movingout.maps.shapes import circumradius
from movingout.maps.surface import surface_distance
from movingout.world.scoring import delivered_items
from movingout.world.state import WorldState

_CELL = 0.06
_SIDE = 40
_BODY = 0.125  # units kept from walls and items
Blocked = npt.NDArray[np.bool_]


class Near:
    """Takes the nearest item."""

    execute_rows = 1
    patience = 50  # ticks

    def reset(self, episode: EpisodeInfo) -> None:
        self._map, self._seat = episode.map, episode.seat
        self._random = np.random.default_rng([7, episode.seed, episode.seat])
        self._goal, self._avoid = -1, dict[int, int]()
        self._held_since, self._spot = -1, (9.0, 9.0)
        self._still, self._before, self._escape = 0, (9.0, 9.0), 0
        self._way = 0.0

    def act(self, observation: Observation) -> ActionChunk:
        state = observation.state
        speed, heading, press = self.decide(state)
        x, y, angle = state.robot_poses[self._seat].tolist()
        if self._escape > 0:
            self._escape -= 1
            speed, heading, press = -0.8, self._way, False
        elif abs(speed) > 0.2 and math.dist((x, y), self._before) < 0.008:
            self._still += 1
            if self._still > 8:
                self._still, self._escape, self._way = 0, 6, angle + float(self._random.uniform(-2, 2))
        else:
            self._still = 0
        self._before = (x, y)
        return np.array([[speed, math.cos(heading), math.sin(heading), float(press)]])

    def wanted(self, state: WorldState, items: list[int]) -> int:
        """Which of the items to take."""
        me = state.robot_poses[self._seat]
        return min(items, key=lambda item: math.dist(state.item_poses[item][:2], me[:2]))

    def decide(self, state: WorldState) -> tuple[float, float, bool]:
        """Speed, heading, press."""
        mine, theirs = int(state.held[self._seat]), int(state.held[1 - self._seat])
        done = delivered_items(self._map, state.item_poses)
        if mine >= 0:
            return self._bring(state, mine, bool(done[mine]))
        self._held_since = -1
        items = [
            item
            for item in range(len(self._map.items))
            if not done[item]
            and self._avoid.get(item, 0) <= state.tick
            and not (item == theirs and self._map.items[item].size == "small")
        ]
        if not items:
            return 0.0, 0.0, False
        if self._goal not in items or state.tick % 20 == 0:
            self._goal = self.wanted(state, items)
        return self._fetch(state, self._goal)

    def _fetch(self, state: WorldState, item: int) -> tuple[float, float, bool]:
        x, y, angle = state.robot_poses[self._seat].tolist()
        ix, iy, _ = state.item_poses[item].tolist()
        towards = math.atan2(-(ix - x), iy - y)
        if self._gap(state, item, x - 0.095 * math.sin(angle), y + 0.095 * math.cos(angle)) < 0.036:
            return 0.0, angle, True
        if self._gap(state, item, x, y) < 0.17:
            return (0.4 if abs(math.remainder(towards - angle, 2 * math.pi)) < 0.4 else 0.005), towards, False
        return 1.0, self._heading(state, (x, y), (ix, iy), {item}), False

    def _bring(self, state: WorldState, item: int, home: bool) -> tuple[float, float, bool]:
        x, y, angle = state.robot_poses[self._seat].tolist()
        ix, iy, _ = state.item_poses[item].tolist()
        if self._held_since < 0 or math.dist((ix, iy), self._spot) > 0.05:
            self._held_since, self._spot = state.tick, (ix, iy)
        if home or state.tick - self._held_since > self.patience:
            self._avoid[item] = state.tick + 40
            self._held_since = -1
            return 0.0, angle, True
        goals = [((goal.left + goal.right) / 2, (goal.bottom + goal.top) / 2) for goal in self._map.goals]
        start = (x, y) if self._map.items[item].size == "small" else (ix, iy)
        goal = min(goals, key=lambda place: math.dist(place, start))
        return 1.0, self._heading(state, start, goal, {item}), False

    def _gap(self, state: WorldState, item: int, x: float, y: float) -> float:
        ix, iy, angle = state.item_poses[item].tolist()
        cos, sin = math.cos(angle), math.sin(angle)
        local = np.array([[cos * (x - ix) + sin * (y - iy), -sin * (x - ix) + cos * (y - iy)]])
        return float(surface_distance(self._map.items[item].shape, self._map.items[item].scale, local)[0])

    def _heading(self, state: WorldState, start: tuple[float, float], end: tuple[float, float], own: set[int]) -> float:
        blocked = _blocked(self._map, state, own | {int(held) for held in state.held})
        place = end if _free_view(blocked, start, end) else _towards(blocked, start, end)
        return math.atan2(-(place[0] - start[0]), place[1] - start[1])


class Far(Near):
    """Takes heavy items first, the farthest of them."""

    patience = 80

    def wanted(self, state: WorldState, items: list[int]) -> int:
        me = state.robot_poses[self._seat]
        heavy = [item for item in items if self._map.items[item].size != "small"] or items
        return max(heavy, key=lambda item: math.dist(state.item_poses[item][:2], me[:2]))


class Keys(Near):
    """On keys, and 0.3 s late."""

    patience = 40

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self._past: deque[WorldState] = deque(maxlen=4)
        self._pressed = -9

    def act(self, observation: Observation) -> ActionChunk:
        self._past.append(observation.state)
        late = Observation(self._past[0], observation.tick, observation.seat, observation.encode)
        row = super().act(late)[0]
        press = row[3] > 0.5 and observation.tick - self._pressed > 5
        self._pressed = observation.tick if press else self._pressed
        step = round(math.atan2(row[2], row[1]) / (math.pi / 4)) * math.pi / 4
        speed = math.copysign(1.0, row[0]) if abs(row[0]) > 0.3 else 0.005 * (abs(row[0]) > 0)
        return np.array([[speed, math.cos(step), math.sin(step), float(press)]])


class Shadow(Near):
    """Goes where its partner is."""

    patience = 60

    def wanted(self, state: WorldState, items: list[int]) -> int:
        partner, theirs = state.robot_poses[1 - self._seat], int(state.held[1 - self._seat])
        if theirs in items:
            return theirs
        return min(items, key=lambda item: math.dist(state.item_poses[item][:2], partner[:2]))


def _blocked(the_map: MapSpec, state: WorldState, free: set[int]) -> Blocked:
    axis = (np.arange(_SIDE) + 0.5) * _CELL - 1.2
    x, y = np.meshgrid(axis, axis, indexing="ij")
    blocked: Blocked = (np.abs(x) > 1.2 - _BODY + 0.03) | (np.abs(y) > 1.2 - _BODY + 0.03)
    for wall in the_map.walls:
        blocked |= (
            (x > wall.left - _BODY) & (x < wall.right + _BODY) & (y > wall.bottom - _BODY) & (y < wall.top + _BODY)
        )
    for index, item in enumerate(the_map.items):
        if index not in free:
            ix, iy, _ = state.item_poses[index].tolist()
            blocked |= np.hypot(x - ix, y - iy) < circumradius(item.shape, item.scale) * 0.9 + _BODY - 0.02
    return blocked


def _cell(point: tuple[float, float]) -> tuple[int, int]:
    column, row = int((point[0] + 1.2) / _CELL), int((point[1] + 1.2) / _CELL)
    return min(max(column, 0), _SIDE - 1), min(max(row, 0), _SIDE - 1)


def _free_view(blocked: Blocked, start: tuple[float, float], end: tuple[float, float]) -> bool:
    steps = max(int(math.dist(start, end) / 0.03), 1)
    for k in range(2, steps):
        share = k / steps
        if blocked[_cell((start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])))]:
            return False
    return True


def _towards(blocked: Blocked, start: tuple[float, float], end: tuple[float, float]) -> tuple[float, float]:
    """The middle of the cell three steps along the breadth-first way; the end itself where there is none."""
    first, last = _cell(start), _cell(end)
    came: dict[tuple[int, int], tuple[int, int]] = {last: last}
    queue = deque([last])
    while queue and first not in came:
        cell = queue.popleft()
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)):
            beside = (cell[0] + dx, cell[1] + dy)
            if not (0 <= beside[0] < _SIDE and 0 <= beside[1] < _SIDE) or beside in came:
                continue
            if blocked[beside] and beside != first and not blocked[cell]:
                continue
            came[beside] = cell
            queue.append(beside)
    if first not in came:
        return end
    cell = first
    for _ in range(3):
        cell = came[cell]
    return ((cell[0] + 0.5) * _CELL - 1.2, (cell[1] + 0.5) * _CELL - 1.2)
