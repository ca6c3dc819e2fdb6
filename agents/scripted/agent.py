"""The scripted agent: perceives, selects a task, drives, and recovers when it is stuck."""

import math
from random import Random

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.errors import AgentError
from movingout.agents.scripted.avoidance import in_contact, partner_collision_cost, partner_path
from movingout.agents.scripted.jam import GiveRoom, JamWatch
from movingout.agents.scripted.navigation.motion_choice import REST, DriveCommand
from movingout.agents.scripted.partner_intent import PartnerIntent
from movingout.agents.scripted.perception import FreeSpaceCache, Perception
from movingout.agents.scripted.placement.goal_places import PlacementCache
from movingout.agents.scripted.style import Style, varied
from movingout.agents.scripted.task_choice import WAIT_ASIDE, TaskSelector
from movingout.agents.scripted.tasks.fetch import Carry, Fetch
from movingout.agents.scripted.tasks.lift import Lift
from movingout.agents.scripted.tasks.task import Task
from movingout.agents.scripted.tasks.wait import Aside, WalkTo
from movingout.world.state import Floats

SLICES_PER_TICK = 2  # of planning; counted rather than timed, so that equal states give equal actions on any machine
STALLED_AFTER = 7  # ticks without progress
AVOID_AGAIN = 40  # ticks between two attempts to go around the partner
WIGGLE_TICKS = 3
YIELD_AFTER_STALLS = 2  # stalls after which it gives way even with the right of way
_AT_HAND = 0.3  # units from a small item within which it can be taken without another step
_BESIDE = 0.5  # units from an item; a stall this near means that the gripper does not reach it


class ScriptedAgent:
    """A planner that plays with any partner on any map. Deterministic given seed and style."""

    execute_rows = 1

    def __init__(
        self,
        seed: int = 0,
        slices: int = SLICES_PER_TICK,
        yields: bool = False,
        adapts: bool = True,
        **habits: float | str,
    ) -> None:
        """`slices`: planning per tick. With a thousand it never pauses to plan, but some decisions take a second.
        `yields`: release a heavy item at once when the partner holds another one, and help there.
        `adapts`: read from the partner's motion what it means, and give in to it; else it takes it for its like.
        `habits`: fields of `Style` that affect plans. Raises AgentError for any other, and for values that cannot be.
        """
        if type(slices) is not int or slices < 1:
            raise AgentError(f"scripted: slices is a whole number from 1, not {slices!r}")
        for name, value in (("yields", yields), ("adapts", adapts)):
            if value not in (True, False):
                raise AgentError(f"scripted: {name} is true or false, not {value!r}")
        self.style: Style = varied(seed, habits)
        self.seed = seed
        self.slices = slices
        self.yields = bool(yields)
        self.adapts = bool(adapts)
        self.anticipates = True  # plans for where items will be, as an expert does
        self.detail: dict[str, object] = {}

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode."""
        self._map = episode.map
        self._random = Random(f"{self.seed}/{episode.seed}/{episode.seat}")
        self._selector = TaskSelector(episode.map, self.style, self.yields)
        self._placements = PlacementCache()
        self._jams = JamWatch()
        self._intent = PartnerIntent(episode.map, episode.seat) if self.adapts else None
        self._floors: FreeSpaceCache = {}
        self._task: Task | None = None
        self._trail: list[Floats] = []
        self._resting = False
        self._wiggle: list[DriveCommand] = []
        self._avoided = -AVOID_AGAIN
        self._stalls = 0

    def act(self, observation: Observation) -> ActionChunk:
        """A chunk of one row. Afterwards `detail` names the task and its item."""
        now = self._perceive(observation)
        self._selector.observe_partner(now)
        self._selector.hear(now, observation.pings)
        command = self._command(now)
        if self._intent is not None:
            self._intent.commanded(command)
        self.detail = {"errand": type(self._task).__name__ if self._task else "", "item": self._item}
        return np.array([[command.distance, math.cos(command.heading), math.sin(command.heading), command.grasp]])

    def _perceive(self, observation: Observation) -> Perception:
        if self._intent is not None:
            self._intent.observe(observation.state)
        return Perception(
            self._map,
            observation.state,
            observation.seat,
            partner_is_still=self._selector.partner_is_still(observation.state.tick),
            anticipates=self.anticipates,
            placements=self._placements,
            free_spaces=self._floors,
            intent=self._intent,
        )

    @property
    def _item(self) -> int:
        return self._task.item if self._task is not None else -1

    def _command(self, now: Perception) -> DriveCommand:
        self._trail = [] if self._resting else [*self._trail[-2 * STALLED_AFTER :], now.pose]
        if self._selector.lets_go_to_help(now):
            self._task, self._wiggle = None, []
            return DriveCommand(0.0, 0.0, grasp=True)
        if self._intent is not None and not self._resting and self._jams.is_jammed(now):
            if self._leaves_jam(now):
                return DriveCommand(0.0, float(now.pose[2]), grasp=True)
        elif not self._wiggle and self._stalled(now):
            self._unblock(now)
        if self._wiggle:
            return self._wiggle.pop()
        command = self._task_command(now)
        self._resting = command is REST
        return command

    def _task_command(self, now: Perception) -> DriveCommand:
        collision_cost = partner_collision_cost(now)
        for _ in range(2):  # a task may end and the next one begin in the same tick
            self._task = self._selector.next_task(now, self._task)
            if self._task is None:
                return REST
            command = self._task.step(now, collision_cost, self.slices)
            if command is not None:
                return command
            self._selector.ended(now, self._task)
            self._task = None
        return REST

    def _stalled(self, now: Perception) -> bool:
        if isinstance(self._task, Aside | WalkTo | GiveRoom | None) or len(self._trail) <= STALLED_AFTER:
            return False
        recent, last = self._trail[-STALLED_AFTER - 1], self._trail[-1]
        limit = self._least_progress(now)
        if len(self._trail) > 2 * STALLED_AFTER and _gap(self._trail[0], last) < limit:
            return True  # moves back and forth without progress
        return _gap(recent, last) < limit and abs(float(last[2] - recent[2])) < 0.3

    def _leaves_jam(self, now: Perception) -> bool:
        """Do something else than to push against the partner; whether that is to put the own item down."""
        self._wiggle, self._trail = [], []
        if isinstance(self._task, Fetch) and self._is_at_hand(now, self._task.item):
            self._task.take_from_here(now)
            return False
        self._task = GiveRoom(now)
        return now.own_item >= 0 and self._jams.is_stubborn(now.tick)

    def _is_at_hand(self, now: Perception, item: int) -> bool:
        return now.own_item < 0 and _gap(now.pose, now.item_pose(item)) < _AT_HAND

    def _least_progress(self, now: Perception) -> float:
        """Units in STALLED_AFTER ticks; less counts as a stall."""
        if now.own_item >= 0 and now.is_heavy(now.own_item):
            return 0.02 if now.own_item == now.partner_item else 0.005
        return 0.05

    def _unblock(self, now: Perception) -> None:
        """React to a stall at the item itself, at the partner, or at a corner."""
        self._trail = []
        task = self._task
        if (
            isinstance(task, Lift | Fetch)
            and now.own_item < 0
            and task.stance >= 0
            and self._is_beside(now, task.item)
            # contact with the partner explains the stall, unless the partner holds this item and so stays where it is
            and (now.partner_item == task.item or not in_contact(now))
        ):
            self._selector.grasp_failed(task)
            self._task = None
        elif in_contact(now) and (now.own_item < 0 or now.own_item != now.partner_item):
            self._yield_to_partner(now)
        else:
            heading = float(now.pose[2]) + self._random.uniform(-0.8, 0.8)
            self._wiggle = WIGGLE_TICKS * [DriveCommand(-1.0 if self._random.random() < 0.7 else 1.0, heading)]

    def _yield_to_partner(self, now: Perception) -> None:
        """React to a partner in the way: go around it, let it pass, or wait for it to move."""
        if isinstance(self._task, Carry | Fetch) and now.tick > self._avoided + AVOID_AGAIN:
            self._avoided = now.tick
            self._task.go_around(now)
        elif self._gives_way(now) and self._selector.leaves_to_partner(now):
            self._task = None
            self._wiggle = [
                *WIGGLE_TICKS * [DriveCommand(-1.0, float(now.pose[2]))],
                DriveCommand(0.0, 0.0, grasp=True),
            ]
            self._stalls = 0
        elif self._gives_way(now):
            path = partner_path(now, self._selector.their_item(now, self._item))
            self._task = Aside(
                now, path, now.tick + WAIT_ASIDE, self._selector.partner_comes_until(now.tick + WAIT_ASIDE)
            )
            self._stalls = 0
        else:
            self._stalls += 1

    def _gives_way(self, now: Perception) -> bool:
        """An empty gripper yields to a full one, a follower to anyone, red to blue, and anyone after some stalls."""
        if self._stalls >= YIELD_AFTER_STALLS or (now.own_item >= 0) == (now.partner_item >= 0):
            modest = now.seat == 1 if self.style.role == "equal" else self.style.role == "follower"
            return self._stalls >= YIELD_AFTER_STALLS or modest
        return now.partner_item >= 0

    def _is_beside(self, now: Perception, item: int) -> bool:
        return _gap(now.pose, now.item_pose(item)) < _BESIDE


def _gap(one: Floats, other: Floats) -> float:
    return float(np.hypot(*(other - one)[:2]))
