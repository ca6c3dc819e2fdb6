"""Who leads when both hold one item: the plan, until the partner pulls another way.

It leads by the plan. When the item does not go as it drives, it stops for a moment and feels where the partner pulls
(at rest, the item moves as the partner drives). If the partner pulls elsewhere it gives in, within a second of the
beginning of the quarrel, and follows for as long as that gets the item on; then it leads again, to the goal that
the partner meant.
"""

import math

import numpy as np

from movingout.agents.scripted.navigation.geometry import forward, heading_of
from movingout.agents.scripted.navigation.motion_choice import REST, DriveCommand
from movingout.agents.scripted.partner_intent import PartnerIntent
from movingout.agents.scripted.perception import Perception
from movingout.world.constants import DRIVE_SPEED
from movingout.world.state import Floats

HINDERED_AFTER = 5  # ticks in which the robot hardly moves as it drives
LISTENS_FOR = 3  # ticks at rest
LEADS_AGAIN_FOR = 15  # ticks for which it does not stop again when it felt no pull
FOLLOWS_AT_LEAST = 10  # ticks
FUTILE_AFTER = 35  # ticks without motion after which both ends had better be taken differently
STUCK_AFTER = 60  # ticks of going to and fro in one place after which something else had better be done
_MOVES = 0.06  # units, with 0.2 for each rad
_GETS_ON = 0.3  # the same
REFUSES = 2  # times that it leads on against a pull to nowhere before it follows that, too
_HARDLY = 0.2  # of the own speed: less along the own heading is hindered
_OPPOSES = 0.3  # of full speed: a pull so strong against the own heading
_PULLS = 0.2  # u/s: less is no pull
_STANDS = 0.05  # u/s
_STANDS_FOR = 8  # ticks


class _Rest:
    """For how long an item has not gone farther than `within` from where it was."""

    def __init__(self, within: float) -> None:
        self.ticks = 0
        self._within = within
        self._place = np.array([9.0, 9.0, 0.0])

    def note(self, pose: Floats, is_home: bool) -> None:
        """Take note of the pose (3,) in one tick; at home it need not go anywhere."""
        x, y, turn = (pose - self._place).tolist()
        if is_home or math.hypot(x, y) + 0.2 * abs(turn) > self._within:
            self._place, self.ticks = pose.copy(), 0
        self.ticks += 1


class JointCarry:
    """The course of one joint carry."""

    def __init__(self) -> None:
        self.goal = -1  # the goal that the partner means, -1 while unknown
        self.follows = False
        self.gave_in = 0  # how often
        self._hindered = 0
        self._listens = 0
        self._leads_until = 0
        self._stands = 0
        self._followed = 0
        self._refused = 0
        self._last: DriveCommand = REST
        self._rests = _Rest(_MOVES)
        self._stuck = _Rest(_GETS_ON)

    def command(self, now: Perception, intent: PartnerIntent, planned: DriveCommand) -> DriveCommand:
        """The command of this tick, given what the plan wants."""
        self._note_motion(now)
        if self._listens:
            self._listen(now, intent)
        elif self.follows:
            self._check_following(now, intent)
        else:
            self._check_leading(now, intent)
        if self._listens:
            return REST
        if self.follows:
            return self._as_partner(now, intent)
        self._last = planned
        return planned

    def follow(self, now: Perception, intent: PartnerIntent) -> DriveCommand:
        """Drive as the partner does, without a plan of one's own."""
        self._note_motion(now)
        return self._as_partner(now, intent)

    @property
    def is_futile(self) -> bool:
        """Whether the item has not got anywhere for long, however it was led."""
        return self._rests.ticks > FUTILE_AFTER

    @property
    def is_stuck(self) -> bool:
        """Whether the item has moved, but not got on for long: to take it differently has not helped, or would not."""
        return self._stuck.ticks > STUCK_AFTER

    def _note_motion(self, now: Perception) -> None:
        is_home = bool(now.delivered[now.own_item])
        for rest in (self._rests, self._stuck):
            rest.note(now.item_pose(now.own_item), is_home)

    def _check_leading(self, now: Perception, intent: PartnerIntent) -> None:
        """Give in to a partner that pulls the other way, or stop to feel where it pulls when nothing moves."""
        wanted = self._last
        if abs(wanted.distance) <= 0.3 or now.tick < self._leads_until:
            self._hindered = 0
            return
        own = math.copysign(1.0, wanted.distance) * np.array(forward(wanted.heading))
        velocity = now.state.robot_velocities[now.seat][:2]
        opposed = float(intent.pull @ own) < -_OPPOSES * DRIVE_SPEED
        hindered = float(velocity @ own) < _HARDLY * DRIVE_SPEED * abs(wanted.distance)
        self._hindered = self._hindered + 1 if opposed or hindered else 0
        if self._hindered < HINDERED_AFTER:
            return
        self._hindered = 0
        if opposed and float(np.hypot(*now.state.robot_velocities[:, :2].mean(axis=0))) > _STANDS:
            self._give_in(now, intent)  # it moves freely, so the pull is the partner's and not that of a wall
        else:
            self._listens = LISTENS_FOR + 1

    def _give_in(self, now: Perception, intent: PartnerIntent) -> None:
        """Follow a partner that pulls to a goal; one that pulls nowhere only when leading has not helped."""
        goal = intent.goal_pulled_to(now.state, now.own_item)
        if goal < 0 and self._refused < REFUSES:
            self._refused += 1
            self._leads_until = now.tick + 2 * LEADS_AGAIN_FOR
            return
        self.follows, self._followed, self._stands, self._refused = True, 0, 0, 0
        self.gave_in += 1
        self.goal = goal

    def _listen(self, now: Perception, intent: PartnerIntent) -> None:
        self._listens -= 1
        if self._listens:
            return
        self._last = REST
        if float(np.hypot(*intent.pull)) < _PULLS:
            self._leads_until = now.tick + LEADS_AGAIN_FOR
            return
        self._give_in(now, intent)

    def _check_following(self, now: Perception, intent: PartnerIntent) -> None:
        """Lead again when the partner rests or its way ends somewhere."""
        self._followed += 1
        rests = float(np.hypot(*intent.pull)) < _PULLS / 2
        speed = float(np.hypot(*now.state.robot_velocities[now.seat][:2]))
        self._stands = self._stands + 1 if rests or speed < _STANDS else 0
        if self._stands >= _STANDS_FOR and self._followed >= FOLLOWS_AT_LEAST:
            self.follows = False
            self._leads_until = now.tick + 2 * LEADS_AGAIN_FOR

    def _as_partner(self, now: Perception, intent: PartnerIntent) -> DriveCommand:
        """Drive as the partner does, and turn with the item."""
        velocities = now.state.robot_velocities[:, :2]
        vx, vy = (intent.pull + velocities[now.seat] - velocities.mean(axis=0)).tolist()
        speed = min(math.hypot(vx, vy) / DRIVE_SPEED, 1.0)
        return DriveCommand(speed, heading_of(vx, vy)) if speed > 0.05 else REST
