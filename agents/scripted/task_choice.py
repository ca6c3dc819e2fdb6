"""What to be busy with: the one decision that a scripted player makes again and again.

It looks at what is to be done, at what the partner does, and remembers what has proved useless.
"""

from collections.abc import Callable

import numpy as np

from movingout.agents.scripted.navigation.grasp_stance import stands_towards
from movingout.agents.scripted.navigation.terrain import Terrain, cell_of
from movingout.agents.scripted.navigation.walking_distance import walk_lengths
from movingout.agents.scripted.placement.handover_lanes import FARTHEST, Relay, relay
from movingout.agents.scripted.situation import Situation
from movingout.agents.scripted.style import Style
from movingout.agents.scripted.tasks.drag import Drag
from movingout.agents.scripted.tasks.fetch import Carry, Fetch
from movingout.agents.scripted.tasks.lift import Lift
from movingout.agents.scripted.tasks.task import Errand
from movingout.agents.scripted.tasks.wait import Aside, WalkTo
from movingout.agents.scripted.traffic import in_goal, partners_way, touching, way_out
from movingout.maps import MapSpec
from movingout.maps.flood_fill import UNREACHED
from movingout.world.state import Floats

HOPELESS_FOR = 40  # ticks after which a hopeless item is looked at again
HANDED_OVER_FOR = 80  # ticks for which an item is left to the partner
LEFT = 400  # quarter ticks: who has just put something down will not come back for it first
WAIT_ASIDE = 25  # ticks
PASSES_WITHIN = 75  # ticks more that are waited for a partner who has not passed yet
PASSED = 2  # cells of its way before it is nearest: a partner who gets no nearer is past
WAIT_FOR_THINGS = 5  # ticks between two looks whether something has been handed over
IDLE_AFTER = 60  # ticks without motion after which a partner is not counted on
HOLDS_FOR = 150  # ticks for which who holds something may stand still and is not taken for a thing that stands there
LOOK_EVERY = 4  # ticks between two looks whether the partner wants to get out of a lane
OUT_OF_THE_WAY = 0.33  # units between a resting robot and the partner's way
FETCHED_WITHIN = 30  # ticks in which the first thing is taken that was put down far from the goal, or never
ABOUT_TO_TAKE = 0.5  # units between a partner and the item that it is about to take
_REGARD = {"equal": (1.0, 1.0), "leader": (1.0, 0.1), "follower": (0.1, 1.0)}  # of the own way and the partner's
_WHOLE_WAY = 400  # cells
_MOVING = 0.05  # units/s
_WITHIN_REACH = 10  # cells


class Chooser:
    """Chooses errands for one seat of one episode."""

    def __init__(self, the_map: MapSpec, style: Style, yields: bool = False) -> None:
        self.style = style
        self._yields = yields
        self._usual = relay(the_map, Style().handover)
        self._relay = relay(the_map, style.handover)
        is_usual = self._relay.meeting == self._usual.meeting
        self._farthest = self._usual if is_usual else relay(the_map, FARTHEST)  # from where it fetches
        self._lying: dict[int, int] = {}  # item: tick at which it was first seen to wait for the partner in a lane
        self._met = self._relay.meeting <= self._usual.meeting  # whether the partner comes to the meeting place
        self._hopeless: dict[int, int] = {}  # item: tick until which it is not looked at
        self._useless: dict[int, set[int]] = {}  # item: stands from which the hand did not reach it
        self._tidied: set[int] = set()
        self._partner_moved = -1  # nothing seen yet
        self._let_down = 0  # heavy items in a row at which nobody came
        self._taken = (-1, 0)  # what the partner holds, and since which tick
        self._left: dict[int, int] = {}  # item that the partner put down on the way: since which tick
        self._moved = 0  # the tick at which this player itself moved last
        self._far = -1  # the farthest item as it was chosen: on the way another one becomes the farthest

    # ---- what it learns ---------------------------------------------------------------------------------------

    def watch(self, now: Situation) -> None:
        """Note what the partner does."""
        moves = float(np.hypot(*now.state.robot_velocities[1 - now.seat][:2])) > _MOVING
        looked_at = bool(self._lying) and not self._met
        if moves or looked_at or self._partner_moved < 0:  # who is met for the first time is trusted to do something
            self._partner_moved = now.tick
        if now.mine >= 0 or now.theirs >= 0 or float(np.hypot(*now.state.robot_velocities[now.seat][:2])) > _MOVING:
            self._moved = now.tick
        if now.waiting and min(now.tick - self._moved, now.tick - self._partner_moved) > IDLE_AFTER:
            self._begin_anew(now.tick)
        if now.theirs != self._taken[0]:
            if self._taken[0] in now.waiting and not now.is_heavy(self._taken[0]):
                self._left[self._taken[0]] = now.tick
            self._taken = now.theirs, now.tick
            self._met |= now.theirs in self._lying
        if now.mine >= 0:
            self._useless.pop(now.mine, None)
            if now.mine == now.theirs:
                self._let_down = 0

    def partner_comes_until(self, tick: int) -> Callable[[Situation], bool]:
        """Whether to stand aside still: up to a tick, and on while the partner has not passed."""
        comes = True

        def needed(now: Situation) -> bool:
            nonlocal comes
            if now.tick % LOOK_EVERY == 0:
                way = partners_way(now, self.their_item(now, now.mine))
                comes = int(np.argmin(np.hypot(*(way - now.pose[:2]).T))) > PASSED and self.partner_is_active(now.tick)
            return now.tick < tick or (comes and now.tick < tick + PASSES_WITHIN)

        return needed

    def leaves_to_partner(self, now: Situation) -> bool:
        """Whether to put down here what the partner, with empty hands and nearer to the goal, can take home."""
        item = now.mine
        if item < 0 or now.is_heavy(item) or now.theirs >= 0 or not self._is_outer(now, 1 - now.seat):
            return False
        self._hopeless[item] = now.tick + HANDED_OVER_FOR
        return True

    def _begin_anew(self, tick: int) -> None:
        """Both stand there with empty hands, each because it thinks that the other one does nothing: trust it again."""
        self._moved = self._partner_moved = tick
        self._let_down = 0
        self._hopeless.clear()
        self._useless.clear()

    def partner_is_active(self, tick: int) -> bool:
        """Whether the partner has moved lately."""
        return self._partner_moved < 0 or tick - self._partner_moved < IDLE_AFTER

    def partner_is_still(self, tick: int) -> bool:
        """Whether the partner is better taken for a thing that stands there."""
        waits = self._taken[0] >= 0 and tick - self._taken[1] < HOLDS_FOR  # for somebody at the other end
        return not self.partner_is_active(tick) and not waits

    def ended(self, now: Situation, errand: Errand) -> None:
        """Note how an errand went."""
        if isinstance(errand, Aside) and errand.handed_over >= 0:
            self._hopeless[errand.handed_over] = now.tick + HANDED_OVER_FOR
        if isinstance(errand, Lift) and errand.given_up is not None:
            self._useless[errand.item] = stands_towards(errand.given_up)
        if errand.hopeless:
            self._hopeless[errand.item] = now.tick + HOPELESS_FOR
            self._useless.pop(errand.item, None)
            self._let_down += isinstance(errand, Lift) and errand.waited_in_vain

    def in_vain(self, errand: Fetch | Lift) -> None:
        """Note that the hand did not reach the item from this errand's stand."""
        self._useless.setdefault(errand.item, set()).add(errand.stand)

    # ---- what it decides --------------------------------------------------------------------------------------

    def next_errand(self, now: Situation, errand: Errand | None) -> Errand | None:
        """What to be busy with in this tick: mostly what it was."""
        if isinstance(errand, Aside):
            return errand
        if now.mine >= 0:
            return self._with_full_hand(now, errand)
        if self._is_asked(now) and (isinstance(errand, Lift) or now.tick - self._taken[1] >= self.style.help_after):
            return errand if isinstance(errand, Lift) and errand.item == now.theirs else self._lift(now, now.theirs)
        if isinstance(errand, Lift) and self._is_led_to_another(now, errand):
            return self._lift(now, self.their_item(now, -1))
        if isinstance(errand, Fetch) and now.tick in self._left.values():
            errand = None  # the partner has just left something: that may be nearer
        return errand or self._choose(now) or self._rest(now)

    def their_item(self, now: Situation, own: int) -> int:
        """What the partner probably walks to, -1 for nothing."""
        items = [item for item in now.waiting if item != own] or now.waiting
        gaps = [float(np.hypot(*(now.item_pose(item)[:2] - now.partner[:2]))) for item in items]
        return items[int(np.argmin(gaps))] if items else -1

    def _is_asked(self, now: Situation) -> bool:
        """Whether the partner holds something that it cannot bring home alone."""
        return now.theirs >= 0 and now.is_heavy(now.theirs) and self._possible(now, now.theirs)

    def _is_led_to_another(self, now: Situation, errand: Lift) -> bool:
        """Whether a follower sees the partner begin another heavy item than its own one."""
        if self.style.role != "follower" or now.theirs >= 0:
            return False
        item = self.their_item(now, -1)
        if item in (-1, errand.item) or not now.is_heavy(item):
            return False
        return float(np.hypot(*(now.item_pose(item) - now.partner)[:2])) < ABOUT_TO_TAKE and self._possible(now, item)

    def _with_full_hand(self, now: Situation, errand: Errand | None) -> Errand:
        item = now.mine
        if now.is_heavy(item):
            alone = isinstance(errand, Drag) and now.theirs != item
            return (
                errand
                if errand and errand.item == item and (alone or isinstance(errand, Lift))
                else self._lift(now, item)
            )
        if not (isinstance(errand, Carry) and errand.item == item):
            known = errand.haul if isinstance(errand, Fetch) and errand.item == item else None
            return Carry(now, item, known, self._meeting(now))
        free = not self._relay.locked and item not in self._left  # what the partner has left is not handed back to it
        if now.tick % LOOK_EVERY == 0 and free and self.partner_is_active(now.tick):
            way = way_out(now, self._relay.last_lane, self.their_item(now, item))
            if way is not None:
                return Aside(now, way, now.tick, self._partner_leaves, hands_over=now.foresees and bool(now.waiting))
        return errand

    def _choose(self, now: Situation) -> Errand | None:
        cost, their_cost = self._distances(now)
        heavies = [item for item in cost if now.is_heavy(item) and not self._is_asked(now)]
        smalls = [item for item in cost if not now.is_heavy(item)]
        helpful = self.partner_is_active(now.tick) and self._let_down < 2
        if heavies and now.theirs < 0 and helpful and (self.style.heavy_first or not smalls):
            return self._lift(now, min(heavies, key=lambda item: (self._joint(cost[item], their_cost[item]), item)))
        if smalls and self._in_relay(now):
            return self._relay_errand(now, smalls, cost)
        if smalls:
            return self._fetch(now, self._divide(smalls, cost, their_cost, now))
        if self._is_asked(now):
            return self._lift(now, now.theirs)  # nothing of its own to go on with: no reason to let the partner wait
        if heavies:
            follows = helpful and self.style.role == "follower"
            return self._alone(now, heavies, their_cost if follows else cost, helpful)
        return self._tidy(now)

    def _alone(self, now: Situation, heavies: list[int], cost: dict[int, float], helpful: bool) -> Errand:
        """Only heavy items are left, and the partner is busy or of no help."""
        middles = [item for item in heavies if now.item(item).size == "middle"]
        if middles and not helpful:
            return Drag(now, min(middles, key=cost.__getitem__))
        return self._lift(now, min(heavies, key=cost.__getitem__))

    def _distances(self, now: Situation) -> tuple[dict[int, float], dict[int, float]]:
        """Quarter ticks to the items that can be had: the own way and the partner's."""
        items = [item for item in now.waiting if self._possible(now, item)]
        if not items:
            return {}, {}
        poses = [now.item_pose(item) for item in items]
        ground = now.ground()
        mine = dict(zip(items, _costs_to(ground, now.pose, poses), strict=True))
        theirs = dict(zip(items, _costs_to(ground, now.partner, poses), strict=True))
        for item, since in self._left.items():
            if item in theirs and now.tick - since < HANDED_OVER_FOR:
                theirs[item] += LEFT
        return {item: cost for item, cost in mine.items() if cost < UNREACHED}, theirs

    def _divide(self, smalls: list[int], mine: dict[int, float], theirs: dict[int, float], now: Situation) -> int:
        """Which small item to take so that both together walk least; or the farthest, for who likes that."""
        if self.style.far_first:
            if self._far in smalls:
                return self._far
            if self.style.role == "follower" and now.theirs < 0:
                nearest = min(smalls, key=theirs.__getitem__)
                smalls = [item for item in smalls if item != nearest] or smalls
            self._far = max(smalls, key=lambda item: (mine[item], -item))
            return self._far
        if len(smalls) == 1 or now.theirs >= 0:
            return min(smalls, key=lambda item: (mine[item], item))
        pairs = [(one, other) for one in smalls for other in smalls if one != other]
        return min(pairs, key=lambda pair: (self._joint(mine[pair[0]], theirs[pair[1]]), mine[pair[0]]))[0]

    def _joint(self, mine: float, theirs: float) -> int:
        """Quarter ticks of both ways, as much as this player regards each."""
        own, other = _REGARD[self.style.role]
        return round(own * mine + other * theirs)

    def _tidy(self, now: Situation) -> Errand | None:
        """Nothing else can be done: put something that lies in the way, or badly, to a better place."""
        smalls = [item for item in np.flatnonzero(now.delivered).tolist() if not now.is_heavy(item)]
        smalls = [item for item in smalls if self._possible(now, item) and item not in self._tidied]
        if not smalls or not now.waiting or now.theirs >= 0:
            return None
        item = min(smalls, key=lambda item: float(np.hypot(*(now.item_pose(item) - now.pose)[:2])))
        self._tidied.add(item)
        return Fetch(now, item, frozenset(), None, self.style.detour, tidying=True)

    def _rest(self, now: Situation) -> Errand | None:
        """Nothing to do: stay, but out of the partner's way."""
        way = partners_way(now, self.their_item(now, -1), _WHOLE_WAY)
        if touching(now):  # it goes another way than one would think
            way = np.vstack([way, now.pose[:2]])
        in_the_way = bool(in_goal(now.map)[cell_of(float(now.pose[0]), float(now.pose[1]))])
        if in_the_way or float(np.hypot(*(way - now.pose[:2]).T).min()) < OUT_OF_THE_WAY:
            return Aside(now, way, now.tick + WAIT_ASIDE)
        return None

    def _possible(self, now: Situation, item: int) -> bool:
        return self._hopeless.get(item, 0) <= now.tick

    def _lift(self, now: Situation, item: int) -> Lift:
        useless = frozenset(self._useless.get(item, ()))
        return Lift(now, item, self.style.patience, useless, self._yields, self.style.side)

    def _fetch(self, now: Situation, item: int) -> Fetch:
        useless = frozenset(self._useless.get(item, ()))
        return Fetch(now, item, useless, self._meeting(now), self.style.detour, side=self.style.side)

    # ---- lanes ------------------------------------------------------------------------------------------------

    def _partner_leaves(self, now: Situation) -> bool:
        """Whether the partner is still on its way out of the last lane."""
        partner = cell_of(float(now.partner[0]), float(now.partner[1]))
        inside = bool(self._relay.last_lane[partner] or in_goal(now.map)[partner])
        return inside and self.partner_is_active(now.tick) and bool(now.waiting)

    def _in_relay(self, now: Situation) -> bool:
        """Whether the two take turns on a lane that nobody can pass: not with a partner who does nothing."""
        return self._relay.locked and self.partner_is_active(now.tick)

    def _is_outer(self, now: Situation, seat: int = -1) -> bool:
        """Whether the robot of a seat, or this one, is nearer to the goal than the other one."""
        seat = now.seat if seat < 0 else seat
        return self._relay.left(now.robots[seat]) < self._relay.left(now.robots[1 - seat])

    def _meeting(self, now: Situation) -> Relay | None:
        return self._relay if self._in_relay(now) and not self._is_outer(now) else None

    def _relay_errand(self, now: Situation, smalls: list[int], cost: dict[int, float]) -> Errand | None:
        if self._is_outer(now):
            handed = [item for item in smalls if self._farthest.is_handed_over(now.item_pose(item))]
            if not handed:
                return WalkTo(now, self._relay.waiting_place(), now.tick + WAIT_FOR_THINGS)
            return self._fetch(now, min(handed, key=lambda item: self._relay.left(now.item_pose(item))))
        ready = [item for item in smalls if not self._relay.is_handed_over(now.item_pose(item))]
        if not self._met and len(ready) < len(smalls):
            since = min(self._lying.setdefault(item, now.tick) for item in smalls if item not in ready)
            if now.tick - since <= FETCHED_WITHIN:
                return None  # a second thing would shut the lane if the partner does not come for the first one
            self._relay, self._met = self._usual, True
            ready = [item for item in smalls if not self._relay.is_handed_over(now.item_pose(item))]
        return self._fetch(now, min(ready, key=cost.__getitem__)) if ready else None


def _costs_to(ground: Terrain, position: Floats, poses: list[Floats]) -> list[float]:
    """Quarter ticks on foot to within reach of each pose."""
    grid = walk_lengths(ground, [(float(position[0]), float(position[1]))])
    costs = []
    for pose in poses:
        row, column = cell_of(float(pose[0]), float(pose[1]))
        rows = slice(max(row - _WITHIN_REACH, 0), row + _WITHIN_REACH + 1)
        columns = slice(max(column - _WITHIN_REACH, 0), column + _WITHIN_REACH + 1)
        costs.append(float(grid[rows, columns].min()))
    return costs
