"""Skills as tasks of the scripted agent: what a language model has chosen, carried out tick by tick."""

from collections import deque
from collections.abc import Sequence

from movingout.agents.llm.answers import ALONE, Skill
from movingout.agents.scripted.avoidance import partner_path
from movingout.agents.scripted.jam import GiveRoom
from movingout.agents.scripted.navigation.motion_choice import REST, CollisionCost, DriveCommand
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.style import Style
from movingout.agents.scripted.task_choice import WAIT_ASIDE, TaskSelector
from movingout.agents.scripted.tasks.fetch import Carry, Fetch
from movingout.agents.scripted.tasks.lift import Lift
from movingout.agents.scripted.tasks.task import Task
from movingout.agents.scripted.tasks.wait import Aside
from movingout.maps import MapSpec

HELPS_FOR = 100  # ticks without anything to help with, after which helping is over


class Stay:
    """Staying where one is, with whatever one holds."""

    item = -1
    infeasible = False

    def __init__(self, until: int) -> None:
        self.until = until

    def step(self, now: Perception, collision_cost: CollisionCost, slices: int) -> DriveCommand | None:
        """Ends at the tick `until`."""
        return REST if now.tick < self.until else None


class SkillSelector(TaskSelector):
    """Does the skills of a list in turn, then the fallback until there is another list."""

    def __init__(self, the_map: MapSpec, style: Style, fallback: Skill) -> None:
        super().__init__(the_map, style)
        self._fallback = fallback
        self._skills: deque[Skill] = deque()
        self._had = False  # the item of the skill has been in the own hand
        self._idle_since = -1  # the tick since which there has been nothing to help with
        self._failed: list[str] = []
        self._changed = False  # whether another skill than before has been chosen since the last tick

    @property
    def skill(self) -> Skill:
        """What is being done."""
        return self._skills[0] if self._skills else self._fallback

    @property
    def has_skills(self) -> bool:
        """Whether something of the list is left to do."""
        return bool(self._skills)

    def choose(self, skills: Sequence[Skill]) -> None:
        """Do these instead. What is being done already goes on."""
        same = bool(self._skills) and bool(skills) and self._skills[0] == skills[0] and skills[0].name != "wait"
        self._skills = deque(skills)
        if not same:
            self._changed = True
            self._begin()

    def failures(self) -> list[str]:
        """What could not be done since the last call, in words."""
        failed, self._failed = self._failed, []
        return failed

    def lets_go_to_help(self, now: Perception) -> bool:
        """Whether to release a heavy item that is held alone, because the skill needs a free hand."""
        item, skill = now.own_item, self.skill
        if skill.name == ALONE:
            return super().lets_go_to_help(now)
        if item < 0 or not now.is_heavy(item) or item == now.partner_item:
            return False
        if skill.name == "help":
            return self._needs_help(now) or super().lets_go_to_help(now)
        return skill.name == "step_aside" or skill.item not in (-1, item)

    def ended(self, now: Perception, task: Task) -> None:
        """Note the outcome of a task, and of the skill that it belongs to."""
        super().ended(now, task)
        skill = self.skill
        waited = isinstance(task, Stay) and skill.name == "wait"
        made_room = isinstance(task, Aside) and (skill.name == "step_aside" or task.handed_over == skill.item >= 0)
        if waited or made_room:
            self._next()
        elif task.infeasible and task.item == skill.item >= 0:
            alone = isinstance(task, Lift) and task.waited_in_vain
            why = (
                "nobody came to the other end"
                if alone
                else "there is no way to it now; perhaps something else is before it"
            )
            self._failed.append(f"{skill}: {why}")
            self._next()

    def next_task(self, now: Perception, task: Task | None) -> Task | None:
        """The task for this tick, usually the current one."""
        self._drop_what_is_done(now)
        skill = self.skill
        needed = skill.name == "help" and now.own_item < 0 and self._needs_help(now)
        if isinstance(task, Aside) and (self._changed or needed):
            task = None
        self._changed = False
        if isinstance(task, Aside | GiveRoom):
            return task
        if skill.name == ALONE:
            return super().next_task(now, None if isinstance(task, Stay) else task)
        if skill.name == "wait":
            return task if isinstance(task, Stay) else Stay(now.tick + skill.ticks)
        if skill.name == "step_aside":
            path = partner_path(now, self.their_item(now, now.own_item))
            return Aside(now, path, now.tick + WAIT_ASIDE)
        if skill.name == "help":
            return self._helping(now, task)
        if now.own_item >= 0:
            return self._bringing(now, None if isinstance(task, Stay) else task)
        return self._getting(now, task, skill.item)

    def _drop_what_is_done(self, now: Perception) -> None:
        """Items that are delivered need nothing more, nor does what was handed over."""
        while self._skills and (item := self._skills[0].item) >= 0:
            self._had |= now.own_item == item
            handed = self._skills[0].name == "hand_over" and self._had and now.own_item != item
            theirs = now.partner_item == item and not now.is_heavy(item) and now.own_item != item
            lies_ready = self._lies_ready(now, item)
            if not (handed or theirs or lies_ready or (now.delivered[item] and now.own_item != item)):
                return
            if lies_ready and not self._had:
                self._failed.append(f"{self._skills[0]}: it lies where your partner takes it")
            self._next()

    def _lies_ready(self, now: Perception, item: int) -> bool:
        """Whether a small item lies in a lane where the partner takes over, and none of them holds it."""
        free = item not in (now.own_item, now.partner_item) and not now.is_heavy(item)
        return free and self._handover(now) is not None and self._lane.is_handed_over(now.item_pose(item))

    def _getting(self, now: Perception, task: Task | None, item: int) -> Task:
        if isinstance(task, Lift | Fetch) and task.item == item:
            return task
        if now.is_heavy(item):
            return self._lift(now, item)
        return self._fetch(now, item)

    def _bringing(self, now: Perception, task: Task | None) -> Task:
        """What to do with the item in the own hand: to the goal, or to the partner."""
        item, skill = now.own_item, self.skill
        if skill.name != "hand_over" or skill.item != item or now.is_heavy(item):
            return self._task_while_holding(now, task)
        if self._lane.locked and not self._is_nearer_goal(now):
            return task if isinstance(task, Carry) and task.item == item else Carry(now, item, None, self._lane)
        path = partner_path(now, item)
        return Aside(now, path, now.tick + HELPS_FOR, hands_over=True)

    def _helping(self, now: Perception, task: Task | None) -> Task | None:
        """To the item that the partner cannot carry alone, or to where it asks for help; else out of its way."""
        needed = self._needs_help(now) or self._request.is_open(now) or now.own_item >= 0
        if needed:
            self._idle_since = -1
        elif self._idle_since < 0:
            self._idle_since = now.tick
        elif now.tick - self._idle_since >= HELPS_FOR and self._skills:
            self._next()
        if now.own_item >= 0:
            return self._task_while_holding(now, None if isinstance(task, Stay) else task)
        if self._request.is_open(now):
            return self._requested_task(now, task)
        if self._needs_help(now):
            same = isinstance(task, Lift) and task.item == now.partner_item
            return task if same else self._lift(now, now.partner_item)
        return self._idle_task(now)

    def _next(self) -> None:
        if self._skills:
            self._skills.popleft()
        self._begin()

    def _begin(self) -> None:
        self._had, self._idle_since = False, -1
