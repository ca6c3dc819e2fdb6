"""A partner for people who are learning: takes one end of a heavy item, waits, and follows whoever takes the other.

It carries nothing alone and does not choose the way: without a partner who drives, nothing is delivered.
"""

import math

from movingout.agents.base import EpisodeInfo
from movingout.agents.scripted.agent import ScriptedAgent
from movingout.agents.scripted.navigation.geometry import heading_of
from movingout.agents.scripted.navigation.motion_choice import REST, DriveCommand
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.task_choice import TaskSelector
from movingout.agents.scripted.tasks.lift import Lift
from movingout.agents.scripted.tasks.task import Task
from movingout.world.constants import DRIVE_SPEED

STANDS_STILL = 0.02  # [u/s], slower is no driving
PUSH = 1.5  # of the partner's speed: an item that two hold slows both


class PatientPartner(ScriptedAgent):
    """Helps with heavy items once the partner has delivered a small one, where there are any."""

    def __init__(self, seed: int = 0) -> None:
        super().__init__(seed, adapts=False)

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self._selector = _HeavyOnly(episode, self)

    def _command(self, now: Perception) -> DriveCommand:
        if now.own_item >= 0 and now.own_item == now.partner_item:
            return self._follow(now)
        if now.own_item >= 0 and not now.delivered[now.own_item]:
            return REST  # for as long as it takes
        return super()._command(now)

    def _follow(self, now: Perception) -> DriveCommand:
        vx, vy, _ = now.state.robot_velocities[1 - now.seat].tolist()
        speed = math.hypot(vx, vy)
        if speed < STANDS_STILL:
            return DriveCommand(0.0, float(now.pose[2]))
        return DriveCommand(min(1.0, PUSH * speed / DRIVE_SPEED), heading_of(vx, vy))


class _HeavyOnly(TaskSelector):
    """Chooses nothing but the nearest heavy item that is not delivered."""

    def __init__(self, episode: EpisodeInfo, player: ScriptedAgent) -> None:
        super().__init__(episode.map, player.style)
        self._small = [index for index, item in enumerate(episode.map.items) if item.size != "large"]
        self._called = not self._small

    def next_task(self, now: Perception, task: Task | None) -> Task | None:
        self._called = self._called or any(bool(now.delivered[index]) for index in self._small)
        heavy = [index for index, done in enumerate(now.delivered) if now.is_heavy(index) and not done]
        if not self._called or (not heavy and now.own_item < 0):
            return None
        if isinstance(task, Lift) and (task.item in heavy or task.item == now.own_item):
            return task
        return self._lift(now, now.own_item if now.own_item >= 0 else heavy[0])
