"""The scripted partner: looks, decides what to be busy with, and drives."""

import math
from random import Random

import numpy as np

from agents.base import ActionChunk, EpisodeInfo, Observation
from agents.scripted.driving import REST, Command
from agents.scripted.errands import Aside, Carry, Errand, Fetch, Lift, WalkTo
from agents.scripted.lattice import UNREACHED
from agents.scripted.relay import Relay, relay
from agents.scripted.situation import Situation
from agents.scripted.style import Style, varied
from agents.scripted.terrain import Terrain, cell_of
from agents.scripted.traffic import gap_to, in_goal, meeting_danger, partners_way, touching, way_out
from agents.scripted.walking import grid_of, walk_field
from world.state import Floats

SLICES_PER_TICK = 2
HOPELESS_FOR = 40  # ticks after which a hopeless item is looked at again
STALLED_AFTER = 7  # ticks without getting on
WAIT_ASIDE = 25  # ticks
WHOLE_WAY = 400  # cells
LOOK_EVERY = 4  # ticks between two looks whether the partner wants to get out
AVOID_AGAIN = 40  # ticks between two attempts to go around the partner
IDLE_AFTER = 60  # ticks without motion after which a partner is not counted on


class ScriptedAgent:
    """Plays sensibly with anybody on any map; deterministic given its seed and style."""

    execute_rows = 1

    def __init__(self, seed: int = 0) -> None:
        self.style: Style = varied(seed)
        self.seed = seed
        self.detail: dict[str, object] = {}

    def reset(self, episode: EpisodeInfo) -> None:
        self._episode = episode
        self._random = Random(f"{self.seed}/{episode.seed}/{episode.seat}")
        self._errand: Errand | None = None
        self._hopeless: dict[int, int] = {}
        self._relay = relay(episode.map)
        self._partner_moved = 0
        self._tidied: set[int] = set()
        self._avoided = -AVOID_AGAIN
        self._useless: dict[int, set[int]] = {}  # stands beside an item that were no use
        self._trail: list[Floats] = []
        self._wiggle = 0
        self._wiggle_heading = self._wiggle_distance = 0.0
        self._resting = False
        self._patient = 0

    def act(self, observation: Observation) -> ActionChunk:
        now = Situation(self._episode.map, observation.state, observation.seat)
        command = self._command(now)
        self.detail = {"errand": type(self._errand).__name__, "item": self._errand.item if self._errand else -1}
        row = [command.distance, math.cos(command.heading), math.sin(command.heading), float(command.grasp)]
        return np.array([row])

    def _command(self, now: Situation) -> Command:
        if float(np.hypot(*now.state.robot_velocities[1 - now.seat][:2])) > 0.05:
            self._partner_moved = now.tick
        self._trail = [] if self._resting else [*self._trail[-2 * STALLED_AFTER:], now.pose]
        if self._stalled(now):
            self._unblock(now)
        if self._wiggle > 0:
            self._wiggle -= 1
            return Command(self._wiggle_distance, self._wiggle_heading)
        danger = meeting_danger(now)
        for _ in range(2):
            self._keep_or_choose(now)
            self._resting = True
            if self._errand is None:
                return REST
            command = self._errand.step(now, danger, SLICES_PER_TICK)
            if command is not None:
                self._resting = command is REST
                return command
            self._end(now)
        return REST

    def _stalled(self, now: Situation) -> bool:
        if isinstance(self._errand, Aside | WalkTo | None) or self._wiggle or len(self._trail) <= STALLED_AFTER:
            return False
        recent, last = self._trail[-STALLED_AFTER - 1], self._trail[-1]
        limit = 0.02 if now.mine >= 0 and now.mine == now.theirs else 0.05
        if len(self._trail) > 2 * STALLED_AFTER and _moved(self._trail[0], last) < limit:
            return True  # turning about without getting anywhere
        return _moved(recent, last) < limit and abs(float(last[2] - recent[2])) < 0.3

    def _unblock(self, now: Situation) -> None:
        """Something is in the way: the partner, or a corner."""
        self._trail = []
        if isinstance(self._errand, Lift | Fetch) and now.mine < 0 and self._errand.stand >= 0 and self._beside(now):
            self._useless.setdefault(self._errand.item, set()).add(self._errand.stand)
            self._errand = None  # the hand does not reach the item from here: think again
            return
        if touching(now) and (now.mine < 0 or now.mine != now.theirs):
            if isinstance(self._errand, Carry | Fetch) and now.tick > self._avoided + AVOID_AGAIN:
                self._avoided = now.tick
                self._errand.go_around(now)
            elif self._gives_way(now):
                self._errand = Aside(now, partners_way(now, self._their_item(now)), now.tick + WAIT_ASIDE)
                self._patient = 0
            else:
                self._patient += 1
            return
        self._wiggle = 3
        self._wiggle_heading = float(now.pose[2]) + self._random.uniform(-0.8, 0.8)
        self._wiggle_distance = -1.0 if self._random.random() < 0.7 else 1.0

    def _gives_way(self, now: Situation) -> bool:
        if self._patient >= 2:
            return True
        mine, theirs = now.mine >= 0, now.theirs >= 0
        if mine != theirs:
            return theirs
        return now.seat == 1

    def _their_item(self, now: Situation) -> int:
        """What the partner probably walks to."""
        own = self._errand.item if self._errand else -1
        items = [item for item in now.waiting if item != own] or now.waiting
        if not items:
            return -1
        gaps = [float(np.hypot(*(now.item_pose(item)[:2] - now.partner[:2]))) for item in items]
        return items[int(np.argmin(gaps))]

    def _end(self, now: Situation) -> None:
        if self._errand is not None and getattr(self._errand, "hopeless", False):
            self._hopeless[self._errand.item] = now.tick + HOPELESS_FOR
            self._useless.pop(self._errand.item, None)
        self._errand = None

    def _keep_or_choose(self, now: Situation) -> None:
        errand = self._errand
        if isinstance(errand, Aside):
            return
        if now.mine >= 0:
            self._useless.pop(now.mine, None)
            if now.is_heavy(now.mine):
                if not (isinstance(errand, Lift) and errand.item == now.mine):
                    self._errand = self._lift(now, now.mine)
            elif not (isinstance(errand, Carry) and errand.item == now.mine):
                known = errand.haul if isinstance(errand, Fetch) and errand.item == now.mine else None
                self._errand = Carry(now, now.mine, known, self._meeting(now))
            elif self._partner_is_active(now) and now.tick % LOOK_EVERY == 0:
                way = None if self._relay.locked else way_out(now, self._relay.last_lane, self._their_item(now))
                if way is not None:
                    self._errand = Aside(now, way, now.tick, self._partner_leaves)
            return
        helping = now.theirs >= 0 and now.is_heavy(now.theirs) and self._possible(now, now.theirs)
        if helping and not (isinstance(errand, Lift) and errand.item == now.theirs):
            self._errand = self._lift(now, now.theirs)
        elif errand is None:
            self._errand = self._choose(now) or self._rest(now)

    def _rest(self, now: Situation) -> Errand | None:
        """Nothing to do: stay, but out of the partner's way."""
        way = partners_way(now, self._their_item(now), WHOLE_WAY)
        in_the_way = bool(in_goal(now.map)[cell_of(float(now.pose[0]), float(now.pose[1]))])
        if in_the_way or float(gap_to(way, now.pose[0:1], now.pose[1:2])[0]) < 0.33:
            return Aside(now, way, now.tick + WAIT_ASIDE)
        return None

    def _partner_leaves(self, now: Situation) -> bool:
        """Whether the partner is still on its way out of the last lane."""
        partner = cell_of(float(now.partner[0]), float(now.partner[1]))
        inside = bool(self._relay.last_lane[partner] or in_goal(now.map)[partner])
        return inside and self._partner_is_active(now) and bool(now.waiting)

    def _partner_is_active(self, now: Situation) -> bool:
        return now.tick - self._partner_moved < IDLE_AFTER

    def _in_relay(self, now: Situation) -> bool:
        """Whether the two take turns on a lane that nobody can pass: not with a partner who does nothing."""
        return self._relay.locked and self._partner_is_active(now)

    def _is_outer(self, now: Situation) -> bool:
        """Whether this robot is the one nearer to the goal."""
        return self._relay.left(now.pose) < self._relay.left(now.partner)

    def _meeting(self, now: Situation) -> Relay | None:
        return self._relay if self._in_relay(now) and not self._is_outer(now) else None

    def _relay_errand(self, now: Situation, smalls: list[int], cost: dict[int, float]) -> Errand | None:
        handed = {item: self._relay.is_handed_over(now.item_pose(item)) for item in smalls}
        if self._is_outer(now):
            ready = [item for item in smalls if handed[item]]
            if not ready:
                return WalkTo(now, self._relay.waiting_place(), now.tick + WAIT_ASIDE // 5)
            return self._fetch(now, min(ready, key=lambda item: self._relay.left(now.item_pose(item))))
        ready = [item for item in smalls if not handed[item]]
        return self._fetch(now, min(ready, key=cost.__getitem__)) if ready else None

    def _lift(self, now: Situation, item: int) -> Lift:
        return Lift(now, item, self.style.patience, frozenset(self._useless.get(item, ())))

    def _fetch(self, now: Situation, item: int) -> Fetch:
        return Fetch(now, item, frozenset(self._useless.get(item, ())), self._meeting(now))

    def _beside(self, now: Situation) -> bool:
        """Whether the robot has come close to the item it is after."""
        item = now.item_pose(self._errand.item)
        return bool(np.hypot(*(item[:2] - now.pose[:2])) < 0.5)

    def _possible(self, now: Situation, item: int) -> bool:
        return self._hopeless.get(item, 0) <= now.tick

    def _choose(self, now: Situation) -> Errand | None:
        open_items = [item for item in now.waiting if self._possible(now, item)]
        if not open_items:
            return self._tidy(now)
        poses = [now.item_pose(item) for item in open_items]
        ground = now.ground()
        cost = dict(zip(open_items, _costs_to(ground, now.pose, poses), strict=True))
        their_cost = dict(zip(open_items, _costs_to(ground, now.partner, poses), strict=True))
        heavies = [item for item in open_items if now.is_heavy(item) and cost[item] < UNREACHED]
        smalls = [item for item in open_items if not now.is_heavy(item) and cost[item] < UNREACHED]
        if heavies and now.theirs < 0 and (self.style.heavy_first or not smalls):
            item = min(heavies, key=lambda item: (round(cost[item] + their_cost[item]), item))
            return self._lift(now, item)
        if self._in_relay(now) and not heavies:
            return self._relay_errand(now, smalls, cost)
        if smalls:
            return self._fetch(now, _divide(smalls, cost, their_cost, now))
        if heavies:
            return self._lift(now, min(heavies, key=cost.__getitem__))
        return self._tidy(now)

    def _tidy(self, now: Situation) -> Errand | None:
        """Nothing else can be done: put something that lies in the way, or badly, to a better place."""
        smalls = [item for item in np.flatnonzero(now.delivered).tolist() if not now.is_heavy(item)]
        smalls = [item for item in smalls if self._possible(now, item) and item not in self._tidied]
        if not smalls or not now.waiting or now.theirs >= 0:
            return None
        gaps = [_moved(now.pose, now.item_pose(item)) for item in smalls]
        item = smalls[int(np.argmin(gaps))]
        self._tidied.add(item)
        return Fetch(now, item, frozenset(), None, tidying=True)


def _divide(smalls: list[int], mine: dict[int, float], theirs: dict[int, float], now: Situation) -> int:
    """Which small item to take so that both together walk least."""
    if len(smalls) == 1 or now.theirs >= 0:
        return min(smalls, key=lambda item: (mine[item], item))
    pairs = [(one, other) for one in smalls for other in smalls if one != other]
    return min(pairs, key=lambda pair: (round(mine[pair[0]] + theirs[pair[1]]), mine[pair[0]]))[0]


def _costs_to(ground: Terrain, position: Floats, poses: list[Floats]) -> list[float]:
    """Quarter ticks on foot to within reach of each pose."""
    grid = grid_of(walk_field(ground, [(float(position[0]), float(position[1]))]))
    costs = []
    for pose in poses:
        row, column = cell_of(float(pose[0]), float(pose[1]))
        window = grid[max(row - 10, 0) : row + 11, max(column - 10, 0) : column + 11]
        costs.append(float(window.min()))
    return costs


def _moved(one: Floats, other: Floats) -> float:
    return float(np.hypot(*(other - one)[:2]))
