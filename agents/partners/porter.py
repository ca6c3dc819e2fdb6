"""The stubborn porter: one item after the other in its own order, each straight to a goal that it never changes.

It walks around obstacles to an item, but carries in a straight line and slides along what is in the way. It does not
let go of a heavy item for half a minute, and it pulls to its own goal whatever its partner does.
"""

import math
from random import Random

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.errors import AgentError
from movingout.agents.partners.walking import Perceiver, Point, StuckRecovery, go_and_grab, goal_centres, walk
from movingout.agents.scripted.navigation.geometry import heading_of
from movingout.agents.scripted.navigation.motion_choice import REST, DriveCommand, drive
from movingout.agents.scripted.perception import Perception
from movingout.world.state import Floats

PATIENCE = 300  # ticks that it holds a heavy item
PATIENCE_LIGHT = 80  # ticks that it carries any other
SLIDES_FOR = 12  # ticks for which it slides to one side
LEAVES_FOR = 150  # ticks for which it leaves alone what it had to give up
_AT_START = 0.25  # units
_SLOW = 0.02  # units in SLOW_TICKS ticks: less is blocked
_SLOW_TICKS = 5
_SIDES = (0.9, -0.9, 1.6, -1.6)  # rad off the straight line, tried one after the other


class StubbornPorter:
    """A partner with an order and a goal of its own. Deterministic given its options and the episode."""

    execute_rows = 1

    def __init__(self, seed: int = 0, patience: int = PATIENCE) -> None:
        """`patience`: ticks that it holds on. Raises AgentError when it is out of range."""
        if not isinstance(patience, int) or not 5 <= patience <= 500:
            raise AgentError(f"porter: patience is a whole number of ticks from 5 to 500, not {patience!r}")
        self.seed, self.patience = seed, patience

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode: the order of the items is drawn once."""
        random = Random(f"porter/{self.seed}/{episode.seed}/{episode.seat}")
        self._perceiver = Perceiver(episode.map, episode.seat)
        self._recovery = StuckRecovery(random)
        self._order = list(range(len(episode.map.items)))
        random.shuffle(self._order)
        robot = episode.map.robots[episode.seat]
        self._start = (robot.x, robot.y)  # where it goes when there is nothing left for it
        self._goal: dict[int, Point] = {}  # by item: where it goes
        self._later: dict[int, int] = {}  # by item: tick until which it is left alone
        self._trail: list[Floats] = []
        self._side, self._slides_until, self._held_since = 0, -1, -1

    def act(self, observation: Observation) -> ActionChunk:
        """A chunk of one row."""
        now = self._perceiver.perceive(observation.state)
        command = self._carry(now) if now.own_item >= 0 else self._recovery.unstuck(now, self._fetch(now))
        return np.array([[command.distance, math.cos(command.heading), math.sin(command.heading), command.grasp]])

    def _fetch(self, now: Perception) -> DriveCommand:
        self._trail, self._held_since = [], -1
        items = [item for item in self._order if not now.delivered[item] and self._is_free(now, item)]
        if items:
            return go_and_grab(now, items[0])
        return walk(now, now.space(), [self._start]) if math.dist(now.pose[:2], self._start) > _AT_START else REST

    def _is_free(self, now: Perception, item: int) -> bool:
        taken = item == now.partner_item and not now.is_heavy(item)
        return not taken and self._later.get(item, 0) <= now.tick

    def _carry(self, now: Perception) -> DriveCommand:
        item = now.own_item
        self._held_since = now.tick if self._held_since < 0 else self._held_since
        patience = self.patience if now.is_heavy(item) else min(self.patience, PATIENCE_LIGHT)
        if now.delivered[item] or now.tick - self._held_since > patience:
            self._later[item] = now.tick + LEAVES_FOR
            return DriveCommand(0.0, float(now.pose[2]), grasp=True)
        x, y, _ = now.item_pose(item).tolist()
        goal = self._goal.setdefault(item, min(goal_centres(now.map), key=lambda centre: math.dist(centre, (x, y))))
        straight = heading_of(goal[0] - x, goal[1] - y)
        self._trail = [*self._trail[-_SLOW_TICKS:], now.item_pose(item)]
        if now.tick >= self._slides_until and self._is_blocked():
            self._side, self._slides_until, self._trail = self._side + 1, now.tick + SLIDES_FOR, []
        if now.tick < self._slides_until and (not now.is_heavy(item) or now.partner_item == item):
            return drive(straight + _SIDES[self._side % len(_SIDES)])
        return drive(straight)

    def _is_blocked(self) -> bool:
        if len(self._trail) <= _SLOW_TICKS:
            return False
        return math.dist(self._trail[0][:2].tolist(), self._trail[-1][:2].tolist()) < _SLOW
