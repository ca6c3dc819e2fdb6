"""What a network sees of each option: lengths of ways, sizes, who holds what, what was tried. Nothing is a place.

| numbers | meaning |
|---|---|
| 0-3 | kind: take, carry, let go, wait |
| 4-6 | the item: small, middle, large |
| 7-9 | way to the item of the own robot and of the partner [100 ticks, at most 3], the former less the latter |
| 10-11 | 1 where there is no such way |
| 12 | own way more than that to the nearest item offered [100 ticks] |
| 13-14 | 1 where the partner, or the own robot, holds the item |
| 15-16 | speed of the partner, and of the own robot, towards it [full speed] |
| 17-18 | way of the item to a goal around walls [arena units, at most 3]; 1 where there is none |
| 19-21 | to be carried: way to its spot [100 ticks]; 1 where there is none; room there less its radius [0.1 units] |
| 22 | the partner is ahead, on the straight line to the target: nearness within 0.6 units times cosine |
| 23-25 | 1 where it goes on, for how long it does, for how long this item was tried [100 ticks] |
| 26-29 | ticks left [500], share delivered, light and heavy items left [5] |
| 30-33 | distance of the robots [arena units], their speeds, ticks of the own hold [100] |
| 34-39 | in the own hand: light, heavy; in the partner's: light, heavy; both on one item; its ticks of hold [100] |
| 40 | how much nearer to its spot the held item has come in the last `BACK` ticks [0.1 units, at most 3] |
"""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from movingout.agents.base import EpisodeInfo
from movingout.agents.partners.options.option import KINDS, RobotOption
from movingout.agents.partners.walking import places_beside
from movingout.agents.scripted.navigation.free_space import cell_of
from movingout.agents.scripted.navigation.walking_route import route_to
from movingout.agents.scripted.perception import Perception
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.shapes import circumradius
from movingout.maps.spec import SIZES
from movingout.world.constants import DRIVE_SPEED
from movingout.world.distance import paper_distances
from movingout.world.state import Floats

Singles = npt.NDArray[np.float32]

SIZE = 41
BACK = 10  # ticks
_MOST = 3.0
_QUARTERS = 400.0  # quarter ticks in 100 ticks
_AHEAD = 0.6  # units


class OptionFeatures:
    """What one seat has seen and tried in an episode, and the features of what it can do next."""

    def __init__(self, episode: EpisodeInfo) -> None:
        self._ticks = episode.ticks
        self._distances = paper_distances(episode.map)
        self._tried = [0] * len(episode.map.items)  # ticks
        self._option, self._since = RobotOption("wait"), 0
        self._held, self._held_since = [-1, -1], [0, 0]
        self._poses: deque[Floats] = deque(maxlen=BACK + 1)  # of items

    def see(self, now: Perception) -> None:
        """A tick goes by: who holds what since when, and what is being tried."""
        for seat, item in enumerate((now.own_item, now.partner_item)):
            if item != self._held[seat]:
                self._held[seat], self._held_since[seat] = item, now.tick
        if self._option.item >= 0:
            self._tried[self._option.item] += 1
        self._poses.append(now.state.item_poses)

    def chosen(self, option: RobotOption, now: Perception) -> None:
        """From now on this is done."""
        if not option.goes_on(self._option):
            self._since = now.tick
        self._option = option

    def of(self, now: Perception, options: Sequence[RobotOption]) -> Singles:
        """The features (K, SIZE) of K options."""
        rows = np.zeros((len(options), SIZE), np.float32)
        rows[:, 26:] = self._shared(now)
        for row, option in zip(rows, options, strict=True):
            row[KINDS.index(option.kind)] = 1.0
            row[23] = option.goes_on(self._option)
            row[24] = min((now.tick - self._since) / 100, _MOST) * row[23]
            if option.item >= 0:
                self._describe(now, option, row)
        taken = rows[:, 0] > 0
        if taken.any():
            rows[taken, 12] = rows[taken, 7] - rows[taken, 7].min()
        return rows

    def _describe(self, now: Perception, option: RobotOption, row: Singles) -> None:
        item, pose = option.item, now.item_pose(option.item)
        row[4 + SIZES.index(now.item(item).size)] = 1.0
        if option.kind == "take":
            route = route_to(now.space(), places_beside(now, item))
            for column, robot in enumerate((now.pose, now.partner)):
                row[7 + column], row[10 + column] = _capped(route.cost(float(robot[0]), float(robot[1])))
            row[9] = row[7] - row[8]
        row[13:15] = now.partner_item == item, now.own_item == item
        row[15:17] = _towards(now, 1 - now.seat, pose), _towards(now, now.seat, pose)
        left = self._distances.one_to_goal(pose[:2])
        row[17:19] = min(left, _MOST), not math.isfinite(left)
        target = pose[:2].tolist()
        if option.kind == "carry":
            target = list(option.spot)
            self._describe_way_home(now, option, row)
        row[22] = _partner_ahead(now, target)
        row[25] = min(self._tried[item] / 100, _MOST)

    def _describe_way_home(self, now: Perception, option: RobotOption, row: Singles) -> None:
        space, (x, y, _) = now.space((option.item,)), now.item_pose(option.item).tolist()
        row[19:21] = _capped(route_to(space, [option.spot]).cost(x, y))
        radius = circumradius(now.item(option.item).shape, now.item(option.item).scale)
        row[21] = min(max((float(space.clearance[cell_of(*option.spot)]) - radius) * 10, -_MOST), _MOST)
        before = math.dist(self._poses[0][option.item, :2], option.spot)
        row[40] = min(max((before - math.dist((x, y), option.spot)) * 10, -_MOST), _MOST)

    def _shared(self, now: Perception) -> list[float]:
        left = np.flatnonzero(~now.delivered).tolist()
        heavy = sum(now.is_heavy(item) for item in left)
        speeds = np.hypot(*now.state.robot_velocities[:, :2].T) / DRIVE_SPEED
        own, other = now.own_item, now.partner_item
        held = [min((now.tick - since) / 100, _MOST) for since in self._held_since]
        return [
            min((self._ticks - now.tick) / 500, _MOST), 1 - len(left) / len(now.map.items),
            (len(left) - heavy) / 5, heavy / 5, math.dist(now.pose[:2], now.partner[:2]),
            float(speeds[now.seat]), float(speeds[1 - now.seat]), held[0] * (own >= 0),
            own >= 0 and not now.is_heavy(own), own >= 0 and now.is_heavy(own),
            other >= 0 and not now.is_heavy(other), other >= 0 and now.is_heavy(other),
            own == other >= 0, held[1] * (other >= 0), 0.0,
        ]  # fmt: skip


def _capped(quarters: float) -> tuple[float, float]:
    """A way in 100 ticks, at most `_MOST`, and 1 where there is none."""
    return min(quarters / _QUARTERS, _MOST), float(quarters >= UNREACHED)


def _towards(now: Perception, seat: int, pose: Floats) -> float:
    """How fast a robot nears a place, as a share of full speed."""
    dx, dy = (pose[:2] - now.robots[seat, :2]).tolist()
    vx, vy = now.state.robot_velocities[seat, :2].tolist()
    return float((dx * vx + dy * vy) / max(math.hypot(dx, dy), 0.01) / DRIVE_SPEED)


def _partner_ahead(now: Perception, target: Sequence[float]) -> float:
    (x, y), (px, py) = now.pose[:2].tolist(), now.partner[:2].tolist()
    dx, dy, ex, ey = target[0] - x, target[1] - y, px - x, py - y
    away = math.hypot(ex, ey)
    cosine = (dx * ex + dy * ey) / max(math.hypot(dx, dy) * away, 1e-6)
    return float(max(1.0 - away / _AHEAD, 0.0) * max(cosine, 0.0))
