"""Jams: both robots push against each other and neither gets on. Who notices it gives room."""

import math
from collections import deque

import numpy as np

from movingout.agents.scripted.avoidance import in_contact
from movingout.agents.scripted.carrying.solo_carry import carried_discs
from movingout.agents.scripted.navigation.free_space import overlap_cost
from movingout.agents.scripted.navigation.geometry import Disc
from movingout.agents.scripted.navigation.grasp_stance import in_frame
from movingout.agents.scripted.navigation.motion_choice import CollisionCost, DriveCommand, best_move
from movingout.agents.scripted.perception import Perception
from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.state import Floats

JAMMED_AFTER = 12  # ticks in contact without getting on
GIVES_ROOM_FOR = (14, 10)  # ticks, of blue and red: different, so that two of the same kind do not meet again
PUTS_DOWN_AFTER = 2  # jams in JAM_MEMORY ticks after which it puts down what it carries
JAM_MEMORY = 80  # ticks
_GOT_ON = 0.12  # units in JAMMED_AFTER ticks
_ROOM = 0.7  # units between the robots that are enough
_WORTH = 150.0  # quarter ticks per unit of room


class JamWatch:
    """Notices jams of one seat in one episode."""

    def __init__(self) -> None:
        self._paths: deque[Floats] = deque(maxlen=JAMMED_AFTER)
        self._jams: deque[int] = deque(maxlen=PUTS_DOWN_AFTER)

    def is_jammed(self, now: Perception) -> bool:
        """Note a tick in which the robot was to move; whether both have been pushing in vain."""
        shared = now.partner_item >= 0 and now.is_heavy(now.partner_item)
        if shared or not in_contact(now):
            self._paths.clear()
            return False
        self._paths.append(now.robots[:, :2].copy())
        if len(self._paths) < JAMMED_AFTER or float(np.abs(self._paths[-1] - self._paths[0]).max()) > _GOT_ON:
            return False
        self._paths.clear()
        self._jams.append(now.tick)
        return True

    def is_stubborn(self, tick: int) -> bool:
        """Whether giving room has not helped of late."""
        return len(self._jams) == PUTS_DOWN_AFTER and tick - self._jams[0] < JAM_MEMORY


class GiveRoom:
    """Moving away from the partner, by the way that is free."""

    item = -1
    infeasible = False

    def __init__(self, now: Perception) -> None:
        self._until = now.tick + GIVES_ROOM_FOR[now.seat]

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Ends after its time, or when there is room."""
        gap = math.dist(now.pose[:2].tolist(), now.partner[:2].tolist())
        if now.tick >= self._until or gap > _ROOM or (now.own_item >= 0 and now.is_heavy(now.own_item)):
            return None
        discs: list[Disc] = [(0.0, 0.0, ROBOT_RADIUS)]
        if now.own_item >= 0:
            discs += carried_discs(now.item(now.own_item), in_frame(now.pose, now.item_pose(now.own_item)))
        space = now.space()

        def cost(moves: Floats) -> Floats:
            room = np.hypot(*(moves[:, -1, :2] - now.partner[:2]).T)
            return np.asarray(overlap_cost(space, discs, moves).max(axis=1) + _WORTH * np.maximum(_ROOM - room, 0.0))

        return best_move(now.pose, cost)[0]
