"""A small scripted driver: it makes episodes in which every kind of carrying happens, on maps without walls."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from maps import load_map
from world import World
from world.constants import REACH, REACH_TOLERANCE

BLUE, RED = 0, 1
CIRCLE = {"Simple": 1, "DistancePriority": 1, "LeftRight": 1}  # index of a round item: easy to face


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

    def drive(self, seat: int, x: float, y: float, near: float = 0.01) -> None:
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

    def toggle(self, seat: int) -> None:
        self._one(seat, 0.0, 0.0, 1.0)

    def both(self, heading: float, ticks: int) -> None:
        for _ in range(ticks):
            self.step((1.0, heading, 0.0), (1.0, heading, 0.0))

    def alone(self, seat: int, heading: float, ticks: int) -> None:
        for _ in range(ticks):
            self._one(seat, 1.0, heading)

    def _one(self, seat: int, distance: float, heading: float, grasp: float = 0.0) -> None:
        mine, still = (distance, heading, grasp), (0.0, 0.0, 0.0)
        self.step(*((mine, still) if seat == BLUE else (still, mine)))


def hold_small() -> Script:
    script = Script("Simple")
    script.grab(RED, CIRCLE["Simple"])
    script.alone(RED, 0.7, 8)
    return script


def hold_middle_alone() -> Script:
    script = Script("DistancePriority")
    script.grab(BLUE, CIRCLE["DistancePriority"])
    script.alone(BLUE, -1.0, 12)
    return script


def hold_middle_with_two() -> Script:
    script = hold_middle_alone()
    script.drive(RED, -0.8, 0.1)
    script.drive(RED, script.world.state().item_poses[1, 0], 0.1)
    script.grab(RED, CIRCLE["DistancePriority"])
    script.both(0.4, 12)
    return script


def hold_large_alone() -> Script:
    script = Script("LeftRight")
    script.drive(BLUE, -0.6, -0.4)
    script.grab(BLUE, CIRCLE["LeftRight"])
    script.alone(BLUE, 1.0, 6)
    return script


def hold_large_with_two() -> Script:
    script = hold_large_alone()
    script.drive(RED, 0.6, -0.4)
    script.grab(RED, CIRCLE["LeftRight"])
    script.both(2.5, 12)
    return script


HOLDS: dict[str, Callable[[], Script]] = {
    "small": hold_small,
    "middle alone": hold_middle_alone,
    "middle with two": hold_middle_with_two,
    "large alone": hold_large_alone,
    "large with two": hold_large_with_two,
}
