"""Labelling by an expert in states that a learner reaches (DAgger, Ross et al. 2011).

A learner plays with a scripted person. Every few seconds the expert takes over for a while, and its actions are the
labels. The expert acts instead of only naming actions, so that its chunks are consistent and its memory is of what
happened. It starts each turn afresh, because a policy without memory could not explain an older plan. Occasionally the
action is perturbed for some ticks, so that recovery is learned too. With the expert as the learner, this makes the
first data.
"""

import math
from dataclasses import dataclass

import numpy as np

from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.data.corrections import Correction
from movingout.agents.data.dataset import Trajectory
from movingout.agents.data.rollout import SeatPlayer
from movingout.agents.errors import AgentError
from movingout.maps import MapSpec
from movingout.world import World
from movingout.world.state import Floats, WorldState

SLIP_CHANCE = 0.01  # per tick
SLIP_TICKS = (3, 9)  # duration of a perturbation
SLIP_PRESS_CHANCE = 0.05  # per tick of a slip
LEARNER_TICKS = (5, 45)  # duration of a turn
EXPERT_TICKS = (20, 80)
EXPERT = "scripted:slices=1000,patience=25,yields=1"
"""The default expert: it never pauses to plan and gives way, so that what it does follows from what is seen."""


@dataclass(frozen=True, slots=True)
class LabellingJob:
    """One episode to be played and labelled."""

    map: MapSpec
    learner: str  # agent id
    expert: str  # agent id
    partner: tuple[str, str]  # name and agent id
    seat: int  # the learner's
    seed: int
    ticks: int

    @property
    def agent_ids(self) -> tuple[str, str]:
        """Of the learner and its partner."""
        return self.learner, self.partner[1]


def label_episode(job: LabellingJob, slips: bool = True) -> Correction:
    """Play one episode; `slips=False` leaves out the perturbations."""
    world = World(job.map, record_sub_poses=False)
    partner_seat = 1 - job.seat
    partner = SeatPlayer(load_agent(job.partner[1]), EpisodeInfo(job.map, partner_seat, job.seed + 1, job.ticks))
    turns = _Turns(job)
    hand = _SlippingHand(job.seed, SLIP_CHANCE if slips else 0.0)
    states, actions, labels, taught = [world.state()], [], [], []
    while world.tick < job.ticks and not world.delivered().all():
        state = states[-1]
        wanted, by_expert = turns.action(state)
        both = np.zeros((2, 3))
        both[job.seat], steady = hand.action(np.array(wanted))
        both[partner_seat] = partner.action(state)
        labels.append(_label(wanted, state, job.seat))
        taught.append(by_expert and steady)
        world.step(both)
        actions.append(both)
        states.append(world.state())
    names = (f"expert:{job.partner[0]}", job.partner[0])
    return Correction(
        Trajectory(
            job.map,
            names if job.seat == 0 else names[::-1],
            np.array([state.robot_poses for state in states]),
            np.array([state.robot_velocities for state in states]),
            np.array([state.held for state in states]),
            np.array([state.item_poses for state in states]),
            np.array(actions).reshape(-1, 2, 3),
        ),
        job.seat,
        np.array(labels, dtype=np.float32).reshape(-1, 5),
        np.array(taught, dtype=np.bool_),
    )


class _Turns:
    """Who acts in the learner's seat: learner and expert by turns, or always the expert."""

    def __init__(self, job: LabellingJob) -> None:
        self._job = job
        self._random = np.random.default_rng([job.seed, 78])
        self._learner = self._player(job.learner) if job.learner != job.expert else None
        self._by_expert = self._learner is None
        self._expert = self._player(job.expert)
        self._left = self._turn()

    def action(self, state: WorldState) -> tuple[tuple[float, float, float], bool]:
        """The world action of the seat, and whether it is the expert's."""
        if self._learner is None:
            return self._expert.action(state), True
        if self._left == 0:
            self._by_expert = not self._by_expert
            self._left = self._turn()
            if self._by_expert:
                self._expert = self._player(self._job.expert)
            else:
                self._learner.decide_anew()
        self._left -= 1
        own = self._learner.action(state)  # in the expert's turns too: what it remembers is then what happened
        return (self._expert.action(state) if self._by_expert else own), self._by_expert

    def _turn(self) -> int:
        return int(self._random.integers(*(EXPERT_TICKS if self._by_expert else LEARNER_TICKS)))

    def _player(self, agent_id: str) -> SeatPlayer:
        job = self._job
        return SeatPlayer(load_agent(agent_id), EpisodeInfo(job.map, job.seat, job.seed, job.ticks))


def _label(wanted: tuple[float, float, float], state: WorldState, seat: int) -> list[float]:
    """A world action as targets (5,): the desired hold level is the present one, or the other after a press.

    At rest, the heading label is the present heading, so that no arbitrary heading has to be learned.
    """
    distance, heading, press = wanted
    facing = heading if distance != 0.0 else float(state.robot_poses[seat, 2])
    hold = 1.0 if (state.held[seat] >= 0) != (press > 0.5) else -1.0
    return [distance, math.cos(facing), math.sin(facing), -hold, hold]


class _SlippingHand:
    """Occasionally replaces actions by a random one for a few ticks."""

    def __init__(self, seed: int, chance: float) -> None:
        """`chance` per tick."""
        self._random = np.random.default_rng([seed, 77])
        self._chance = chance
        self._left = 0
        self._action = np.zeros(3)

    def action(self, wanted: Floats) -> tuple[Floats, bool]:
        """The action (3,) to execute, and whether it is the intended one."""
        if self._left == 0 and self._random.random() < self._chance:
            self._left = int(self._random.integers(*SLIP_TICKS))
            self._action = np.array([self._random.uniform(0.0, 1.0), self._random.uniform(-np.pi, np.pi), 0.0])
        if self._left == 0:
            return wanted, True
        self._left -= 1
        self._action[2] = self._random.random() < SLIP_PRESS_CHANCE
        return self._action, False


def labelling_jobs(
    maps: list[MapSpec], partners: list[tuple[str, str]], learner: str, expert: str, count: int, ticks: int, seed: int
) -> list[LabellingJob]:
    """`count` episodes per map, with seats and partners in turn; maps alternate, so that any prefix is useful.

    Of an odd number, seats change with every second seed: with each one, a partner would always meet the same seat.
    Raises AgentError without partners.
    """
    if not partners:
        raise AgentError("labelling needs at least one partner")
    made = []
    for number in range(count):
        for index, the_map in enumerate(maps):
            turn = seed * 7919 + index * count + number
            partner = partners[turn % len(partners)]
            seat = (number + index + (seed + 1) // 2 * count) % 2
            made.append(LabellingJob(the_map, learner, expert, partner, seat, turn, ticks))
    return made


def shuffled_partners(partners: list[tuple[str, str]], count: int, seed: int) -> list[tuple[str, str]]:
    """`count` partners, each as often as the others but for one time, in a random order.

    Families and the modes of generated maps both come in turn: without this, a family would meet one mode only.
    """
    random = np.random.default_rng([seed, 78])
    rounds = -(-count // len(partners)) if partners else 0
    return [partners[index] for _ in range(rounds) for index in random.permutation(len(partners))][:count]
