"""Two people who know what to do: they carry the items of `Simple` home through inputs alone."""

import math
from dataclasses import dataclass, field

from tests.server.support import Ear, Table

REACH = 0.195  # from robot centre to item centre, when the hand can grab
ERRANDS = {0: [(0, (-0.9, 0.8)), (2, (-0.75, 0.55))], 1: [(1, (0.9, 0.8))]}  # seat: [(item, robot's goal)]


@dataclass
class Carrier:
    """Fetches one item after the other for one seat."""

    seat: int
    errands: list[tuple[int, tuple[float, float]]]
    grabs: int = 0
    waiting: int = field(default=0)  # ticks until the last press shows

    def decide(self, table: Table) -> tuple[float, float, int]:
        """Move, heading and press counter for the coming tick."""
        state = table.room.round.state
        if not self.errands:
            return 0.0, 0.0, self.grabs
        item, goal = self.errands[0]
        holds = state.held[self.seat] == item
        x, y, angle = state.robot_poses[self.seat]
        target = goal if holds else tuple(state.item_poses[item, :2])
        dx, dy = target[0] - x, target[1] - y
        heading = math.atan2(-dx, dy)
        away = math.hypot(dx, dy)
        facing = abs(math.remainder(heading - angle, 2 * math.pi)) < 0.1
        self.waiting -= 1
        if self.waiting < 0 and away < (0.05 if holds else REACH) and (holds or facing):
            self.grabs += 1
            self.waiting = 2
            if holds:
                self.errands.pop(0)
            return 0.0, heading, self.grabs
        speed = 0.005 if away < REACH and not holds else min(1.0, away / 0.12)
        return speed, heading, self.grabs


def deliver_simple(table: Table, blue: Ear, red: Ear, most: int = 400) -> None:
    """Play until the round is over."""
    carriers = [Carrier(seat, list(errands)) for seat, errands in ERRANDS.items()]
    for _ in range(most):
        if table.phase != "playing":
            return
        for ear, carrier in zip((blue, red), carriers, strict=True):
            move, heading, grabs = carrier.decide(table)
            table.push(ear, carrier.seat, move, heading, grabs)
        table.step()
    raise AssertionError(f"not delivered after {most} ticks: {table.room.round.delivered}")
