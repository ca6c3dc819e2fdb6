"""Task selection: which item to fetch, lift or drag next, or where to wait.

The choice depends on the remaining items, on what the partner does, and on what has failed before.
"""

from collections.abc import Callable

import numpy as np

from movingout.agents.scripted.avoidance import exit_path, goal_area, in_contact, partner_path
from movingout.agents.scripted.handover_trust import HandoverTrust
from movingout.agents.scripted.help_request import HelpRequest
from movingout.agents.scripted.jam import GiveRoom
from movingout.agents.scripted.navigation.free_space import cell_of
from movingout.agents.scripted.navigation.grasp_stance import stances_facing
from movingout.agents.scripted.navigation.walking_route import costs_beside
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.placement.handover_lanes import FARTHEST, HandoverLane, handover_lane
from movingout.agents.scripted.rearrangement import Rearrangement
from movingout.agents.scripted.style import Style
from movingout.agents.scripted.tasks.drag import Drag
from movingout.agents.scripted.tasks.fetch import Carry, Fetch
from movingout.agents.scripted.tasks.lift import Lift
from movingout.agents.scripted.tasks.task import Task
from movingout.agents.scripted.tasks.wait import Aside, ComeTo, WalkTo
from movingout.maps import MapSpec
from movingout.maps.flood_fill import UNREACHED
from movingout.world.ping import HelpPing

INFEASIBLE_FOR = 40  # ticks after which an infeasible item is tried again
SMALL_FIRST_FOR = 150  # ticks for which small items come before heavy ones after one got stuck in both hands
LEFT_FOR = 10  # ticks after which an item that was let go for a better one is tried again
HANDED_OVER_FOR = 80  # ticks for which an item is left to the partner
LEFT = 400  # quarter ticks added to the partner's path to an item that it has just put down
WAIT_ASIDE = 25  # ticks
PASSES_WITHIN = 75  # additional ticks to wait for a partner that has not passed yet
PASSED = 2  # cells; a partner whose path comes nearest within these has passed
WAIT_FOR_THINGS = 5  # ticks between two checks for an item that was handed over
IDLE_AFTER = 60  # ticks without motion after which the partner counts as inactive
WAITS_HOLDING_FOR = 150  # ticks for which a partner holding an item is no obstacle
LOOK_EVERY = 4  # ticks between two checks whether the partner is leaving a lane
OUT_OF_THE_WAY = 0.33  # units between an idle robot and the partner's path
FETCHED_WITHIN = 30  # ticks within which a partner that accepts a far handover takes the first item
ABOUT_TO_TAKE = 0.5  # units from an item within which the partner is about to grab it
_PATH_WEIGHTS = {"equal": (1.0, 1.0), "leader": (1.0, 0.1), "follower": (0.1, 1.0)}  # weights of both paths
_WHOLE_WAY = 400  # cells
_MOVING = 0.05  # units/s


class TaskSelector:
    """Selects tasks for one seat in one episode."""

    def __init__(self, the_map: MapSpec, style: Style, yields: bool = False) -> None:
        self.style = style
        self._yields = yields
        self._default_lane = handover_lane(the_map, Style().handover)
        self._lane = handover_lane(the_map, style.handover)
        is_usual = self._lane.handover == self._default_lane.handover
        self._farthest = (
            self._default_lane if is_usual else handover_lane(the_map, FARTHEST)
        )  # fetches from here at most
        self._handed_over_at: dict[int, int] = {}  # by item: tick since when it lies at the handover point
        self._handover_works = (
            self._lane.handover <= self._default_lane.handover
        )  # whether the partner comes to the handover point
        self._handover_trust = HandoverTrust()
        self._infeasible: dict[int, int] = {}  # by item: tick until which it is not tried
        self._failed_stances: dict[int, set[int]] = {}  # by item: stances from which the gripper did not reach it
        self._rearrangement = Rearrangement()
        self._partner_motion_tick = -1  # not seen yet
        self._unanswered = 0  # consecutive heavy items at which the partner did not come
        self._small_first_until = -1  # the tick
        self._partner_grasp = (-1, 0)  # the item that the partner holds, and since which tick
        self._partner_released: dict[int, int] = {}  # by item that the partner put down on the way: the tick
        self._own_motion_tick = 0  # the tick at which this robot last moved or held something
        self._request = HelpRequest()
        self._farthest_item = -1  # the item chosen as the farthest; on the way to it another one becomes the farthest

    # ---- beliefs about the partner and about items ------------------------------------------------------------

    def observe_partner(self, now: Perception) -> None:
        """Update the beliefs about the partner."""
        moves = float(np.hypot(*now.state.robot_velocities[1 - now.seat][:2])) > _MOVING
        looked_at = bool(self._handed_over_at) and not self._handover_works
        if moves or looked_at or self._partner_motion_tick < 0:  # a new partner counts as active
            self._partner_motion_tick = now.tick
        if (
            now.own_item >= 0
            or now.partner_item >= 0
            or float(np.hypot(*now.state.robot_velocities[now.seat][:2])) > _MOVING
        ):
            self._own_motion_tick = now.tick
        if now.waiting and min(now.tick - self._own_motion_tick, now.tick - self._partner_motion_tick) > IDLE_AFTER:
            self._reset_trust(now.tick)
        if now.partner_item != self._partner_grasp[0]:
            if self._partner_grasp[0] in now.waiting and not now.is_heavy(self._partner_grasp[0]):
                self._partner_released[self._partner_grasp[0]] = now.tick
            self._partner_grasp = now.partner_item, now.tick
            if now.intent is not None:
                self._infeasible.pop(now.partner_item, None)  # it is there now
            self._handover_works |= now.partner_item in self._handed_over_at
        if now.own_item >= 0:
            self._failed_stances.pop(now.own_item, None)
            if now.own_item == now.partner_item:
                self._unanswered = 0

    def hear(self, now: Perception, pings: tuple[HelpPing, ...]) -> None:
        """Take note of the partner's pings: where it asks for help, it will come itself."""
        if pings and self._request.hear(now, pings):
            self._infeasible.pop(self._request.item, None)
            self._partner_motion_tick, self._unanswered = now.tick, 0

    def lets_go_to_help(self, now: Perception) -> bool:
        """Whether to release a heavy item that is held alone, because the partner needs help elsewhere."""
        alone = now.own_item >= 0 and now.is_heavy(now.own_item) and now.own_item != now.partner_item
        return alone and self._request.is_open(now) and self._request.item != now.own_item

    def partner_comes_until(self, tick: int) -> Callable[[Perception], bool]:
        """Returns whether to keep standing aside: until `tick`, and on while the partner has not passed."""
        comes = True

        def needed(now: Perception) -> bool:
            nonlocal comes
            if now.tick % LOOK_EVERY == 0:
                path = partner_path(now, self.their_item(now, now.own_item))
                comes = int(np.argmin(np.hypot(*(path - now.pose[:2]).T))) > PASSED and self.partner_is_active(now.tick)
            return now.tick < tick or (comes and now.tick < tick + PASSES_WITHIN)

        return needed

    def leaves_to_partner(self, now: Perception) -> bool:
        """Whether to put the own item down for a partner that has an empty gripper and is nearer to the goal."""
        item = now.own_item
        if item < 0 or now.is_heavy(item) or now.partner_item >= 0 or not self._is_nearer_goal(now, 1 - now.seat):
            return False
        self._infeasible[item] = now.tick + HANDED_OVER_FOR
        return True

    def _reset_trust(self, tick: int) -> None:
        """Both robots idle because each believes the other to be inactive: assume again that the partner is active."""
        self._own_motion_tick = self._partner_motion_tick = tick
        self._unanswered = 0
        self._infeasible.clear()
        self._failed_stances.clear()

    def partner_is_active(self, tick: int) -> bool:
        """Whether the partner has moved recently."""
        return self._partner_motion_tick < 0 or tick - self._partner_motion_tick < IDLE_AFTER

    def partner_is_still(self, tick: int) -> bool:
        """Whether to plan around the partner as an obstacle."""
        waits = (
            self._partner_grasp[0] >= 0 and tick - self._partner_grasp[1] < WAITS_HOLDING_FOR
        )  # for the robot at the other end
        return not self.partner_is_active(tick) and not waits

    def ended(self, now: Perception, task: Task) -> None:
        """Note the outcome of a task."""
        if isinstance(task, Aside) and task.handed_over >= 0:
            self._infeasible[task.handed_over] = now.tick + HANDED_OVER_FOR
        if isinstance(task, Lift) and task.given_up is not None:
            self._failed_stances[task.item] = stances_facing(task.given_up)
        if task.infeasible:
            if task.item == self._request.item:
                self._request.drop()
            early = isinstance(task, Lift) and task.left_early
            self._infeasible[task.item] = now.tick + (LEFT_FOR if early else INFEASIBLE_FOR)
            self._failed_stances.pop(task.item, None)
            if isinstance(task, Lift) and task.got_stuck:
                self._small_first_until = now.tick + SMALL_FIRST_FOR
            self._unanswered += isinstance(task, Lift) and task.waited_in_vain

    def grasp_failed(self, task: Fetch | Lift) -> None:
        """Note that the gripper did not reach the item from this task's stance."""
        self._failed_stances.setdefault(task.item, set()).add(task.stance)

    # ---- selection ----------------------------------------------------------------------------------------------

    def next_task(self, now: Perception, task: Task | None) -> Task | None:
        """The task for this tick, usually the current one."""
        if now.own_item < 0 and self._request.is_open(now):
            return self._requested_task(now, task)
        if isinstance(task, Aside) and (now.intent is None or now.own_item >= 0 or not self._needs_help(now)):
            return task
        if isinstance(task, GiveRoom):
            return task
        if now.own_item >= 0:
            return self._task_while_holding(now, task)
        helps = self._needs_help(now) and not self._has_small_first(now)
        if helps and (isinstance(task, Lift) or now.tick - self._partner_grasp[1] >= self.style.help_after):
            return (
                task if isinstance(task, Lift) and task.item == now.partner_item else self._lift(now, now.partner_item)
            )
        if isinstance(task, Lift) and self._partner_starts_another(now, task):
            return self._lift(now, self.their_item(now, -1))
        if isinstance(task, Fetch) and now.tick in self._partner_released.values():
            task = None  # the partner has just put something down, which may be nearer
        return task or self._choose(now) or self._idle_task(now)

    def their_item(self, now: Perception, own: int) -> int:
        """The item that the partner is probably going to, -1 for none."""
        items = [item for item in now.waiting if item != own] or now.waiting
        gaps = [float(np.hypot(*(now.item_pose(item)[:2] - now.partner[:2]))) for item in items]
        return items[int(np.argmin(gaps))] if items else -1

    def _requested_task(self, now: Perception, task: Task | None) -> Task:
        """The task that the partner has asked for; the current one if it is that already."""
        item, place = self._request.item, self._request.place
        if item < 0:
            same = isinstance(task, ComeTo) and task.place == place
            return task if task and same else ComeTo(now, place, self._request.until)
        if isinstance(task, Lift | Fetch) and task.item == item:
            return task
        return self._lift(now, item) if now.is_heavy(item) else self._fetch(now, item)

    def _needs_help(self, now: Perception) -> bool:
        """Whether the partner holds an item that it cannot deliver alone."""
        return now.partner_item >= 0 and now.is_heavy(now.partner_item) and self._is_feasible(now, now.partner_item)

    def _has_small_first(self, now: Perception) -> bool:
        """Whether a small item is to be fetched before a heavy one, because of late one got stuck."""
        smalls = (item for item in now.waiting if not now.is_heavy(item))
        return now.tick < self._small_first_until and any(self._is_feasible(now, item) for item in smalls)

    def _partner_starts_another(self, now: Perception, task: Lift) -> bool:
        """Whether the partner of a follower is about to lift another heavy item than the follower's."""
        if (self.style.role != "follower" and now.intent is None) or now.partner_item >= 0:
            return False
        if self.style.role != "follower" and not self._is_farther(now, task.item):
            return False
        item = self.their_item(now, -1)
        if item in (-1, task.item) or not now.is_heavy(item):
            return False
        return float(np.hypot(*(now.item_pose(item) - now.partner)[:2])) < ABOUT_TO_TAKE and self._is_feasible(
            now, item
        )

    def _is_farther(self, now: Perception, item: int) -> bool:
        """Whether this robot has farther to go to its item than the partner to the one that it is at."""
        return float(np.hypot(*(now.item_pose(item) - now.pose)[:2])) > 2 * ABOUT_TO_TAKE

    def _task_while_holding(self, now: Perception, task: Task | None) -> Task:
        item = now.own_item
        if now.is_heavy(item):
            alone = isinstance(task, Drag) and now.partner_item != item
            return task if task and task.item == item and (alone or isinstance(task, Lift)) else self._lift(now, item)
        if not (isinstance(task, Carry) and task.item == item):
            known = task.carry_plan if isinstance(task, Fetch) and task.item == item else None
            return Carry(now, item, known, self._handover(now))
        free = (
            not self._lane.locked and item not in self._partner_released
        )  # an item that the partner put down is not handed back
        if now.tick % LOOK_EVERY == 0 and free and self.partner_is_active(now.tick):
            path = exit_path(now, self._lane.last_lane, self.their_item(now, item))
            if path is not None:
                return Aside(
                    now, path, now.tick, self._partner_leaves, hands_over=now.anticipates and bool(now.waiting)
                )
        return task

    def _choose(self, now: Perception) -> Task | None:
        cost, their_cost = self._distances(now)
        heavies = [item for item in cost if now.is_heavy(item) and not self._needs_help(now)]
        smalls = [item for item in cost if not now.is_heavy(item)]
        helpful = self.partner_is_active(now.tick) and self._unanswered < 2
        meant = now.intent.meant(now.state, [*heavies, *smalls]) if now.intent is not None else -1
        if meant in heavies:
            heavies = [meant]
        elif meant in smalls and len(smalls) > 1:
            smalls.remove(meant)
        heavy_first = self.style.heavy_first and now.tick >= self._small_first_until
        if heavies and now.partner_item < 0 and helpful and (heavy_first or not smalls):
            return self._lift(
                now, min(heavies, key=lambda item: (self._joint_cost(cost[item], their_cost[item]), item))
            )
        if smalls and self._uses_handover(now):
            return self._handover_task(now, smalls, cost)
        if smalls:
            return self._fetch(now, self._share_of_small_items(smalls, cost, their_cost, now))
        if self._needs_help(now):
            return self._lift(now, now.partner_item)  # it has no other task, so the partner need not wait
        if heavies:
            follows = helpful and self.style.role == "follower"
            return self._task_without_help(now, heavies, their_cost if follows else cost, helpful)
        return self._rearrange(now)

    def _task_without_help(self, now: Perception, heavies: list[int], cost: dict[int, float], helpful: bool) -> Task:
        """The task when only heavy items are left and the partner is busy or inactive."""
        middles = [item for item in heavies if now.item(item).size == "middle"]
        if middles and not helpful:
            return Drag(now, min(middles, key=cost.__getitem__))
        return self._lift(now, min(heavies, key=cost.__getitem__))

    def _distances(self, now: Perception) -> tuple[dict[int, float], dict[int, float]]:
        """Quarter ticks to the feasible items, for the own robot and for the partner."""
        items = [item for item in now.waiting if self._is_feasible(now, item)]
        if not items:
            return {}, {}
        poses = [now.item_pose(item) for item in items]
        space = now.space()
        mine = dict(zip(items, costs_beside(space, now.pose, poses), strict=True))
        theirs = dict(zip(items, costs_beside(space, now.partner, poses), strict=True))
        for item, since in self._partner_released.items():
            if item in theirs and now.tick - since < HANDED_OVER_FOR:
                theirs[item] += LEFT
        return {item: cost for item, cost in mine.items() if cost < UNREACHED}, theirs

    def _share_of_small_items(
        self, smalls: list[int], mine: dict[int, float], theirs: dict[int, float], now: Perception
    ) -> int:
        """The small item to fetch so that both robots together walk least, or the farthest one for `far_first`."""
        if self.style.far_first:
            if self._farthest_item in smalls:
                return self._farthest_item
            if self.style.role == "follower" and now.partner_item < 0:
                nearest = min(smalls, key=theirs.__getitem__)
                smalls = [item for item in smalls if item != nearest] or smalls
            self._farthest_item = max(smalls, key=lambda item: (mine[item], -item))
            return self._farthest_item
        if len(smalls) == 1 or now.partner_item >= 0:
            return min(smalls, key=lambda item: (mine[item], item))
        pairs = [(one, other) for one in smalls for other in smalls if one != other]
        return min(pairs, key=lambda pair: (self._joint_cost(mine[pair[0]], theirs[pair[1]]), mine[pair[0]]))[0]

    def _joint_cost(self, mine: float, theirs: float) -> int:
        """The two costs weighted by role."""
        own, other = _PATH_WEIGHTS[self.style.role]
        return round(own * mine + other * theirs)

    def _rearrange(self, now: Perception) -> Task | None:
        """When nothing else is feasible: move a delivered item to a better place."""
        item = self._rearrangement.next_item(now, lambda item: self._is_feasible(now, item))
        return Fetch(now, item, frozenset(), None, self.style.detour, rearranging=True) if item >= 0 else None

    def _idle_task(self, now: Perception) -> Task | None:
        """What to do without a task: stay where it is, but off the partner's path."""
        path = partner_path(now, self.their_item(now, -1), _WHOLE_WAY)
        if in_contact(now):  # it does not follow the predicted path
            path = np.vstack([path, now.pose[:2]])
        blocks_goal = bool(goal_area(now.map)[cell_of(float(now.pose[0]), float(now.pose[1]))])
        if blocks_goal or float(np.hypot(*(path - now.pose[:2]).T).min()) < OUT_OF_THE_WAY:
            return Aside(now, path, now.tick + WAIT_ASIDE)
        return None

    def _is_feasible(self, now: Perception, item: int) -> bool:
        return self._infeasible.get(item, 0) <= now.tick

    def _lift(self, now: Perception, item: int) -> Lift:
        failed_stances = frozenset(self._failed_stances.get(item, ()))
        return Lift(now, item, self.style.patience, failed_stances, self._yields, self.style.side)

    def _fetch(self, now: Perception, item: int) -> Fetch:
        failed_stances = frozenset(self._failed_stances.get(item, ()))
        return Fetch(now, item, failed_stances, self._handover(now), self.style.detour, side=self.style.side)

    # ---- handover in lanes --------------------------------------------------------------------------------------

    def _partner_leaves(self, now: Perception) -> bool:
        """Whether the partner is still leaving the last lane."""
        partner = cell_of(float(now.partner[0]), float(now.partner[1]))
        inside = bool(self._lane.last_lane[partner] or goal_area(now.map)[partner])
        return inside and self.partner_is_active(now.tick) and bool(now.waiting)

    def _uses_handover(self, now: Perception) -> bool:
        """Whether items are handed over, because the robots cannot pass each other and the partner is active."""
        return self._lane.locked and self.partner_is_active(now.tick) and self._handover_trust.lasts(now.tick)

    def _is_nearer_goal(self, now: Perception, seat: int = -1) -> bool:
        """Whether the robot of a seat (default: the own) is nearer to the goal than the other."""
        seat = now.seat if seat < 0 else seat
        return self._lane.left(now.robots[seat]) < self._lane.left(now.robots[1 - seat])

    def _handover(self, now: Perception) -> HandoverLane | None:
        return self._lane if self._uses_handover(now) and not self._is_nearer_goal(now) else None

    def _handover_task(self, now: Perception, smalls: list[int], cost: dict[int, float]) -> Task | None:
        if self._is_nearer_goal(now):
            handed = [item for item in smalls if self._farthest.is_handed_over(now.item_pose(item))]
            if not handed and self._handover_trust.nobody_brings(now):
                self._handover_trust.is_lost(now)
                return self._fetch(now, min(smalls, key=cost.__getitem__))
            if not handed:
                return WalkTo(now, self._lane.waiting_place(), now.tick + WAIT_FOR_THINGS)
            return self._fetch(now, min(handed, key=lambda item: self._lane.left(now.item_pose(item))))
        ready = [item for item in smalls if not self._lane.is_handed_over(now.item_pose(item))]
        if self._handover_trust.nobody_comes(now, [item for item in smalls if item not in ready]):
            self._handover_trust.is_lost(now)
            return self._fetch(now, min(smalls, key=cost.__getitem__))
        if not self._handover_works and len(ready) < len(smalls):
            since = min(self._handed_over_at.setdefault(item, now.tick) for item in smalls if item not in ready)
            if now.tick - since <= FETCHED_WITHIN:
                return None  # a second item would block the lane if the partner does not come for the first
            self._lane, self._handover_works = self._default_lane, True
            ready = [item for item in smalls if not self._lane.is_handed_over(now.item_pose(item))]
        return self._fetch(now, min(ready, key=cost.__getitem__)) if ready else None
