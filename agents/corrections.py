"""What the expert would have done where a learner went (DAgger, Ross et al. 2011): states of one, labels of the other.

A learner plays with a scripted person while the expert watches from the learner's seat and says in every tick what it
would do. Now and then the learner's hand slips for some ticks, so that the way back is learned too. With the expert
itself as the learner this makes the first data. Kept as .npz of plain arrays.
"""

import io
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.base import EpisodeInfo
from agents.catalogue import load_agent
from agents.dataset import Piece, Singles, Trajectory
from agents.errors import AgentError, DataError
from agents.rollout import Player
from maps import MapSpec, map_from_json, map_to_json
from world import World
from world.state import Floats

SLIP_CHANCE = 0.01  # per tick
SLIP_TICKS = (3, 9)
SLIP_PRESS_CHANCE = 0.05  # per tick of a slip
SUFFIX = ".corrections.npz"
_ARRAYS = ("robot_poses", "robot_velocities", "held", "item_poses", "actions")


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """An episode, the learner's seat in it, and what the expert would have done there."""

    trajectory: Trajectory
    seat: int
    labels: Singles  # (T, 5), the grasp as desired level


@dataclass(frozen=True, slots=True)
class Lesson:
    """One episode to be played: who learns, with whom, where."""

    map: MapSpec
    learner: str  # agent id
    expert: str  # agent id
    partner: tuple[str, str]  # name and agent id
    seat: int  # the learner's
    seed: int
    ticks: int


def teach(lesson: Lesson, slips: bool = True) -> Correction:
    """Play one episode."""
    world = World(lesson.map, record_sub_poses=False)
    episode = EpisodeInfo(lesson.map, lesson.seat, lesson.seed, lesson.ticks)
    partner_seat = 1 - lesson.seat
    learner = Player(load_agent(lesson.learner), episode)
    expert = learner if lesson.learner == lesson.expert else Player(load_agent(lesson.expert), episode)
    partner = Player(
        load_agent(lesson.partner[1]), EpisodeInfo(lesson.map, partner_seat, lesson.seed + 1, lesson.ticks)
    )
    hand = _SlippingHand(lesson.seed) if slips else None
    states, actions, labels = [world.state()], [], []
    while world.tick < lesson.ticks and not world.delivered().all():
        state = states[-1]
        wanted = expert.action(state)
        labels.append(_label(wanted, holding=bool(state.held[lesson.seat] >= 0)))
        both = np.zeros((2, 3))
        both[lesson.seat] = wanted if learner is expert else learner.action(state)
        both[partner_seat] = partner.action(state)
        if hand is not None:
            both[lesson.seat] = hand.action(both[lesson.seat])
        world.step(both)
        actions.append(both)
        states.append(world.state())
    names = (f"expert:{lesson.partner[0]}", lesson.partner[0])
    return Correction(
        Trajectory(
            lesson.map,
            names if lesson.seat == 0 else names[::-1],
            np.array([state.robot_poses for state in states]),
            np.array([state.robot_velocities for state in states]),
            np.array([state.held for state in states]),
            np.array([state.item_poses for state in states]),
            np.array(actions),
        ),
        lesson.seat,
        np.array(labels, dtype=np.float32),
    )


def _label(wanted: tuple[float, float, float], *, holding: bool) -> list[float]:
    """The expert's world action as targets (5,): the hand it wants is the one it has, or the other if it presses."""
    distance, heading, press = wanted
    hold = 1.0 if holding != (press > 0.5) else -1.0
    return [distance, math.cos(heading), math.sin(heading), -hold, hold]


class _SlippingHand:
    """Replaces an action by a random one for a few ticks, now and then."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng([seed, 77])
        self._left = 0
        self._action = np.zeros(3)

    def action(self, wanted: Floats) -> Floats:
        """The action (3,) that is really made."""
        if self._left == 0 and self._random.random() < SLIP_CHANCE:
            self._left = int(self._random.integers(*SLIP_TICKS))
            self._action = np.array([self._random.uniform(0.0, 1.0), self._random.uniform(-np.pi, np.pi), 0.0])
        if self._left == 0:
            return wanted
        self._left -= 1
        self._action[2] = self._random.random() < SLIP_PRESS_CHANCE
        return self._action


def correction_pieces(corrections: Iterable[Correction], layout: str) -> Iterator[Piece]:
    """The learners' seats, with the expert's labels as targets."""
    for one in corrections:
        yield one.trajectory.participants[one.seat], one.trajectory.features(one.seat, layout), one.labels


def save_correction(path: Path, correction: Correction) -> None:
    """Write one file."""
    walk = correction.trajectory
    about = {"map": map_to_json(walk.map), "participants": walk.participants, "seat": correction.seat}
    data = io.BytesIO()
    arrays = {name: getattr(walk, name) for name in _ARRAYS}
    np.savez_compressed(data, about=np.array(json.dumps(about)), labels=correction.labels, **arrays)
    part = path.with_suffix(".part")
    part.write_bytes(data.getvalue())
    part.replace(path)


def load_correction(path: Path) -> Correction:
    """Read one file; DataError for one that is not ours."""
    try:
        with np.load(path, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            arrays = {name: file[name] for name in _ARRAYS}
            labels = file["labels"]
            blue, red = about["participants"]
            walk = Trajectory(map_from_json(about["map"]), (blue, red), **arrays)
            seat = int(about["seat"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DataError(f"{path} is not a file of corrections: {error}") from error
    if labels.shape != (walk.ticks, 5) or seat not in (0, 1):
        raise DataError(f"{path}: labels of shape {labels.shape} for {walk.ticks} ticks; make the file anew")
    return Correction(walk, seat, labels)


def lessons(
    maps: list[MapSpec], partners: list[tuple[str, str]], learner: str, expert: str, count: int, ticks: int, seed: int
) -> list[Lesson]:
    """`count` lessons per map, seats and partners in turn; maps alternate, so that a part is of use too."""
    if not partners:
        raise AgentError("a lesson needs at least one partner")
    made = []
    for number in range(count):
        for index, the_map in enumerate(maps):
            turn = seed * 7919 + index * count + number
            partner = partners[turn % len(partners)]
            made.append(Lesson(the_map, learner, expert, partner, (number + index) % 2, turn, ticks))
    return made
