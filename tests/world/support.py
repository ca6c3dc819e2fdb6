"""A small driver for worlds under test: go there, take that, let go; it keeps the actions."""

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from movingout.maps import load_map
from movingout.world import World
from movingout.world.constants import REACH, REACH_TOLERANCE

BLUE, RED = 0, 1
CIRCLE = 1  # index of the round item, easy to face, on Simple, DistancePriority and LeftRight alike


@dataclass
class Script:
    """Drives the two robots of one world, one after the other, and keeps the actions."""

    map_name: str
    actions: list[npt.NDArray[np.float64]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.world = World(load_map(self.map_name))

    def step(self, blue: tuple[float, float, float], red: tuple[float, float, float]) -> None:
        self.actions.append(np.array([blue, red]))
        self.world.step(self.actions[-1])

    def drive(self, seat: int, x: float, y: float, near: float = 0.04) -> None:
        """Towards a place until so near to it; the other robot stands."""
        for _ in range(100):
            robot_x, robot_y, _ = self.world.state().robot_poses[seat]
            dx, dy = x - robot_x, y - robot_y
            distance = math.hypot(dx, dy)
            if distance < near:
                return
            self._one(seat, min(1.0, distance / 0.06), math.atan2(-dx, dy))
        raise AssertionError("the way is not free")

    def grab(self, seat: int, item: int) -> None:
        """Drive at a round item, with a free way to it, and take hold of it."""
        x, y, _ = self.world.state().item_poses[item]
        self.drive(seat, x, y, near=REACH + REACH_TOLERANCE + self.world.map.items[item].scale)
        self.toggle(seat)
        assert self.world.state().held[seat] == item

    def walk(self, seat: int, *places: tuple[float, float]) -> None:
        for x, y in places:
            self.drive(seat, x, y)

    def toggle(self, seat: int) -> None:
        self._one(seat, 0.0, 0.0, 1.0)

    def toggle_both(self) -> None:
        self.step((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))

    def both(self, heading: float, ticks: int) -> None:
        for _ in range(ticks):
            self.step((1.0, heading, 0.0), (1.0, heading, 0.0))

    def alone(self, seat: int, heading: float, ticks: int) -> None:
        for _ in range(ticks):
            self._one(seat, 1.0, heading)

    def _one(self, seat: int, distance: float, heading: float, grasp: float = 0.0) -> None:
        mine, still = (distance, heading, grasp), (0.0, 0.0, 0.0)
        self.step(*((mine, still) if seat == BLUE else (still, mine)))
