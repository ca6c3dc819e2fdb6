"""Somebody who follows the tutorial: reads its messages and the poses on the screen, and answers with inputs alone."""

import math

from movingout.server import messages as m
from tests.server.support import Ear, Table

REACH = 0.195  # from robot centre to the centre of a small item, when the hand can grab


class Learner:
    """Drives one seat."""

    def __init__(self, table: Table, ear: Ear, seat: int) -> None:
        self.table, self.ear, self.seat = table, ear, seat
        self.grabs = 0
        self._patience = 0  # ticks until the last press shows

    def act(self) -> None:
        """Send the input of the coming tick."""
        move, heading = self._decide()
        self.table.push(self.ear, self.seat, move, heading, self.grabs)

    def _decide(self) -> tuple[float, float]:
        seen = self.ear.last(m.Tutorial)
        assert isinstance(seen, m.Tutorial)
        state = self.table.room.round.state
        angle, held = float(state.robot_poses[self.seat, 2]), int(state.held[self.seat])
        self._patience -= 1
        if seen.done[self.seat] or seen.finished:
            return 0.0, angle
        if seen.step == "drive":
            x, y, _ = seen.rings[self.seat]
            return self._towards(x, y)
        if seen.step == "backward":
            return -1.0, angle
        target = seen.targets[self.seat]
        if held == target:
            if self.table.room.round.delivered[target]:
                self._press()
            return 1.0, 0.0  # up, into the goal
        return self._fetch(target, angle)

    def _fetch(self, target: int, angle: float) -> tuple[float, float]:
        x, y, _ = self.table.room.round.state.item_poses[target].tolist()
        heavy = self.table.room.round.map.items[target].size == "large"
        speed, heading = self._towards(x, y)
        facing = abs(math.remainder(heading - angle, 2 * math.pi)) < 0.1
        near = self._distance(x, y) < (0.35 if heavy else REACH)
        if near and facing:
            self._press()
        return (0.005 if near and not heavy else speed), heading

    def _press(self) -> None:
        if self._patience < 0:
            self.grabs, self._patience = self.grabs + 1, 3

    def _distance(self, x: float, y: float) -> float:
        own = self.table.room.round.state.robot_poses[self.seat].tolist()
        return math.hypot(x - own[0], y - own[1])

    def _towards(self, x: float, y: float) -> tuple[float, float]:
        own = self.table.room.round.state.robot_poses[self.seat].tolist()
        return min(1.0, self._distance(x, y) / 0.12), math.atan2(-(x - own[0]), y - own[1])
