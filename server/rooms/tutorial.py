"""The tutorial: its map, its steps, and when each is done, judged by the states of the world alone.

Five steps on one map, in one round: drive to the ring, grab the glowing item, bring it in and let go, drive backward,
carry a heavy item home with a partner. What somebody has done once stays done, so that nobody does anything twice and
nobody can get stuck; only driving backward counts from its own step on. Where two people play, a step is over when both
have done it.
"""

import math
from dataclasses import replace
from typing import get_args

from movingout.agents.built_in import TUTORIAL_PARTNER
from movingout.maps import TUTORIAL, MapSpec, load_map
from movingout.maps.spec import Pose
from movingout.server import messages as m
from movingout.server.rooms.seat import Seat
from movingout.world.state import WorldState

STEPS: tuple[m.TutorialStep, ...] = get_args(m.TutorialStep)
RINGS = ((-0.6, -0.45), (0.6, -0.45))  # per seat [u]
RING_RADIUS = 0.16  # [u] of a ring: the robot's centre within it counts
BACKWARD_UNITS = 0.3  # [u] to drive backward
LINGER_TICKS = 15  # between the last step and the end: the item is seen to arrive
_BESIDE = 0.3  # [u] of an agent's robot from the centre of the heavy item

PARTNER_NAME = "Partner"

Players = tuple[bool, bool]  # per seat: a person or a program of somebody's, not an agent


def tutorial_map(players: Players) -> MapSpec:
    """The map for these players: an agent has no item of its own and starts beside the heavy one."""
    the_map = load_map(TUTORIAL)
    if all(players):
        return the_map
    alone = 0 if players[0] else 1
    heavy = next(item.pose for item in the_map.items if item.size == "large")
    side = -1.0 if alone else 1.0  # of the heavy item on which the agent waits
    waiting = Pose(heavy.x + side * _BESIDE, heavy.y, side * math.pi / 2)
    robots = (the_map.robots[0], waiting) if alone == 0 else (waiting, the_map.robots[1])
    items = tuple(item for item in the_map.items if item.size == "large" or item.pose.x * RINGS[alone][0] > 0)
    return replace(the_map, robots=robots, items=items, variant=f"tutorial-{'red' if alone else 'blue'}")


def partner_seat(index: int) -> Seat:
    """The seat of the partner that waits for the player."""
    return Seat(index, "agent", TUTORIAL_PARTNER, name=PARTNER_NAME)


class TutorialProgress:
    """How far the players of one round have come."""

    def __init__(self, the_map: MapSpec, players: Players) -> None:
        self._players = players
        self._heavy = next(index for index, item in enumerate(the_map.items) if item.size == "large")
        self._own = [_own_item(the_map, seat) for seat in (0, 1)]
        self._done: dict[m.TutorialStep, list[bool]] = {step: [not player for player in players] for step in STEPS}
        self._backed = [0.0, 0.0]  # [u]
        self._number = 0
        self._finished_at: int | None = None

    @property
    def step(self) -> m.TutorialStep:
        """The step that is to be done; the last one when all are."""
        return STEPS[self._number]

    @property
    def finished(self) -> bool:
        return self._finished_at is not None

    def over(self, tick: int) -> bool:
        """Whether the last step was done a moment before `tick`."""
        return self._finished_at is not None and tick >= self._finished_at + LINGER_TICKS

    def leave(self, seat: int) -> None:
        """A player goes and an agent plays on."""
        for done in self._done.values():
            done[seat] = True
        self._players = (seat != 0 and self._players[0], seat != 1 and self._players[1])

    def update(self, before: WorldState, after: WorldState, delivered: tuple[bool, ...]) -> bool:
        """Judge one tick; True when a step or a player's part in it is done now."""
        known = self._number, self.finished, [*self._done[self.step]]
        for seat in (0, 1):
            self._judge(seat, before, after, delivered)
        if delivered[self._heavy]:
            self._done["lift"] = [True, True]
        while all(self._done[self.step]) and not self.finished:
            if self._number + 1 < len(STEPS):
                self._number += 1
            else:
                self._finished_at = after.tick
        return known != (self._number, self.finished, self._done[self.step])

    def _judge(self, seat: int, before: WorldState, after: WorldState, delivered: tuple[bool, ...]) -> None:
        x, y, angle = after.robot_poses[seat].tolist()
        ring_x, ring_y = RINGS[seat]
        self._note("drive", seat, math.hypot(x - ring_x, y - ring_y) <= RING_RADIUS)
        held, holds = int(before.held[seat]), int(after.held[seat])
        self._note("grab", seat, holds >= 0 and holds != self._heavy)
        self._note("deliver", seat, holds < 0 <= held and held != self._heavy and delivered[held])
        if self.step == "backward":
            moved_x, moved_y = x - float(before.robot_poses[seat, 0]), y - float(before.robot_poses[seat, 1])
            self._backed[seat] += max(0.0, moved_x * math.sin(angle) - moved_y * math.cos(angle))
            self._note("backward", seat, self._backed[seat] >= BACKWARD_UNITS)

    def _note(self, step: m.TutorialStep, seat: int, done: bool) -> None:
        self._done[step][seat] |= done

    def message(self) -> m.Tutorial:
        """What clients show."""
        done = self._done[self.step]
        return m.Tutorial(
            step=self.step,
            number=self._number + 1,
            total=len(STEPS),
            finished=self.finished,
            done=[*done],
            rings=[[*RINGS[seat], RING_RADIUS] if self.step == "drive" and not done[seat] else [] for seat in (0, 1)],
            targets=[self._target(seat) for seat in (0, 1)],
        )

    def _target(self, seat: int) -> int:
        """The item that a seat is to grab."""
        if self._done[self.step][seat]:
            return -1
        if self.step in ("grab", "deliver"):
            return self._own[seat]
        return self._heavy if self.step == "lift" else -1


def _own_item(the_map: MapSpec, seat: int) -> int:
    """The small item on a seat's side, -1 for none."""
    sides = [item.size == "small" and item.pose.x * RINGS[seat][0] > 0 for item in the_map.items]
    return sides.index(True) if any(sides) else -1
