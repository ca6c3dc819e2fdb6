"""The greedy walker: takes whatever is nearest and carries it the shortest way home, without a plan.

It packs nothing, hands nothing over and waits for nobody longer than its patience. It helps where the item that its
partner holds happens to be the nearest.
"""

import math
from random import Random

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.errors import AgentError
from movingout.agents.partners.walking import (
    Perceiver,
    Point,
    StuckRecovery,
    drive_along,
    go_and_grab,
    goal_centres,
    walk,
    way_length,
)
from movingout.agents.scripted.navigation.motion_choice import REST, DriveCommand
from movingout.agents.scripted.navigation.walking_route import route_to
from movingout.agents.scripted.perception import Perception
from movingout.maps.flood_fill import UNREACHED
from movingout.maps.suggestion import known_names

ORDERS = ("near", "far", "light", "heavy")
SHUNS_FOR = 50  # ticks for which an item is left alone that was held in vain
LOOKS_EVERY = 10  # ticks between two choices on the way
_PROGRESS = 4.0  # quarter ticks that an item must come nearer for the patience to start anew
_TAKEN = 0.25  # units from the middle of a goal region within which an item lies in it
_KEEPS = 20.0  # quarter ticks by which another item must be better than the chosen one
_CLASS_COST = 1000.0  # quarter ticks by which a preferred class of items comes first


class GreedyWalker:
    """A partner that takes the nearest item. Deterministic given its options and the episode."""

    execute_rows = 1

    def __init__(self, seed: int = 0, order: str = "near", patience: int = 60) -> None:
        """`order`: which items come first. `patience`: ticks that it holds an item which does not get on.

        Raises AgentError for an unknown order or a patience out of range.
        """
        if order not in ORDERS:
            raise AgentError(f"greedy: unknown order {order!r}; {known_names(str(order), ORDERS)}")
        if not isinstance(patience, int) or not 5 <= patience <= 500:
            raise AgentError(f"greedy: patience is a whole number of ticks from 5 to 500, not {patience!r}")
        self.seed, self.order, self.patience = seed, order, patience

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode."""
        self._random = Random(f"greedy/{self.seed}/{episode.seed}/{episode.seat}")
        self._perceiver = Perceiver(episode.map, episode.seat)
        self._recovery = StuckRecovery(self._random)
        self._target = -1
        robot = episode.map.robots[episode.seat]
        self._start = (robot.x, robot.y)  # where it goes when there is nothing left for it
        self._shunned: dict[int, int] = {}  # by item: tick until which it is left alone
        self._nearest = (0, math.inf)  # since when the own item has not come nearer, and how near [quarter ticks]

    def act(self, observation: Observation) -> ActionChunk:
        """A chunk of one row."""
        now = self._perceiver.perceive(observation.state)
        command = self._recovery.unstuck(now, self.command(now))
        return np.array([[command.distance, math.cos(command.heading), math.sin(command.heading), command.grasp]])

    def command(self, now: Perception) -> DriveCommand:
        """What it does in this tick."""
        if now.own_item >= 0:
            return self.carry(now)
        self._nearest = (now.tick, math.inf)
        self._target = self.choose(now)
        if self._target >= 0:
            return go_and_grab(now, self._target)
        return walk(now, now.space(), [self._start]) if math.dist(now.pose[:2], self._start) > _TAKEN else REST

    def choose(self, now: Perception) -> int:
        """The item to take, -1 for none."""
        items = [item for item in self._takeable(now) if self._shunned.get(item, 0) <= now.tick]
        if self._target in items and (now.tick % LOOKS_EVERY or self._stays_with(now, self._target)):
            return self._target
        costs = {item: self._cost(now, item) - _KEEPS * (item == self._target) for item in items}
        return min(costs, key=lambda item: (costs[item], item), default=-1)

    def _stays_with(self, now: Perception, item: int) -> bool:
        """On the way to the farthest item another one becomes the farthest."""
        return self.order == "far" and way_length(now, item) < UNREACHED

    def _takeable(self, now: Perception) -> list[int]:
        shared = now.partner_item
        return [*now.waiting, *([shared] if shared >= 0 and now.is_heavy(shared) else [])]

    def _cost(self, now: Perception, item: int) -> float:
        cost, light = way_length(now, item), not now.is_heavy(item)
        if self.order == "far":
            return -cost if cost < UNREACHED else cost
        return cost - _CLASS_COST * (light if self.order == "light" else not light if self.order == "heavy" else 0)

    def carry(self, now: Perception) -> DriveCommand:
        """Carry the own item the shortest way; let go of it at home, or when it does not get on for too long."""
        item = now.own_item
        if now.delivered[item] or self._gives_up(now, item):
            self._shunned[item] = now.tick + SHUNS_FOR
            return DriveCommand(0.0, float(now.pose[2]), grasp=True)
        targets = self.targets(now)
        if not now.is_heavy(item):
            return walk(now, now.space(), targets)
        return drive_along(now.item_pose(item), now.space((item,)), targets)

    def targets(self, now: Perception) -> list[Point]:
        """Where things are to go: goal regions with nothing in their middle, while there are any."""
        homes = goal_centres(now.map)
        lying = [
            now.item_pose(item)[:2].tolist() for item in np.flatnonzero(now.delivered).tolist() if item != now.own_item
        ]
        return [home for home in homes if all(math.dist(home, spot) > _TAKEN for spot in lying)] or homes

    def _gives_up(self, now: Perception, item: int) -> bool:
        x, y, _ = now.item_pose(item).tolist()
        left = route_to(now.space((item,)), self.targets(now)).cost(x, y)
        since, nearest = self._nearest
        if left < nearest - _PROGRESS:
            self._nearest = (now.tick, left)
            return False
        return now.tick - since > self.patience
