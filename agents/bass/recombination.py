"""Augmentation by recombination: one seat's motion from one episode, the partner's from another.

Paper, "Recombination of Sub-Trajectories": where an agent starts and ends a stretch in the same places in two episodes
of a map, the partner's motion of one also fits the other. Places are the same when they share the cell of the 48 x 48
grid, the state of the hand, and the eighth of a turn of the heading. A piece is kept only if the engine, started in its
first state, reproduces it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Literal

import numpy as np

from movingout.agents.bass.restored_world import restage
from movingout.agents.data.dataset import Indices, Singles, Trajectory
from movingout.agents.grasp_encoding import toggles
from movingout.maps import MapSpec
from movingout.maps.flood_fill import CELL, PAPER_CELLS
from movingout.maps.spec import ARENA_HALF
from movingout.recordings.progress import with_progress
from movingout.world.errors import WorldError
from movingout.world.state import Floats, WorldState

LENGTH = 8  # ticks of a piece
TOLERANCE = 0.06  # [u] largest distance between the recorded and the simulated end; joints are made again
HEADINGS = 8
TRIES = 8  # per requested piece
Matching = Literal["both-ends", "one-end", "either-end"]
"""`both-ends` is the paper's multi-agent rule, `either-end` its single-agent ablation; `one-end` sees starts only."""


@dataclass(frozen=True, slots=True, eq=False)
class LearnedPart:
    """What is learned from an episode: the targets of one seat, in some stretches."""

    trajectory: Trajectory
    seat: int
    targets: Singles  # (T, 5)
    stretches: tuple[tuple[int, int], ...]  # (first, last + 1) ticks

    @property
    def ticks(self) -> int:
        """In all stretches."""
        return sum(end - begin for begin, end in self.stretches)


@dataclass(frozen=True, slots=True, eq=False)
class RecombinedPiece:
    """LENGTH ticks of `own` from `start`, with the partner of `other` from `other_start`."""

    own: LearnedPart
    start: int
    other: Trajectory
    other_start: int

    @property
    def targets(self) -> Singles:
        """The recorded targets (LENGTH to 2 * LENGTH, 5), including those after the piece."""
        end = next(end for begin, end in self.own.stretches if begin <= self.start < end)
        return self.own.targets[self.start : min(self.start + 2 * LENGTH, end)]


@dataclass(frozen=True, slots=True)
class RecombinationReport:
    """Number of pieces tried and confirmed by the engine."""

    tried: int
    valid: int

    @property
    def share(self) -> float:
        return self.valid / self.tried if self.tried else 0.0


def draw_pieces(parts: Sequence[LearnedPart], seed: int, matching: Matching = "both-ends") -> Iterator[RecombinedPiece]:
    """All ticks at which a piece may start, in random order, each with a random match in another episode.

    Ticks without a match are left out. The partner may come from any tick of the other episode.
    """
    random = np.random.default_rng(seed)
    index = _Index(list(dict.fromkeys(part.trajectory for part in parts)), matching)
    starts = [
        (part, start) for part in parts for begin, end in part.stretches for start in range(begin, end - LENGTH + 1)
    ]
    for number in random.permutation(len(starts)):
        part, start = starts[number]
        others, ticks = index.matches(part.trajectory, part.seat, start)
        if len(others):
            drawn = random.integers(len(others))
            yield RecombinedPiece(part, start, index.trajectories[others[drawn]], int(ticks[drawn]))


def recombined(piece: RecombinedPiece) -> Trajectory | None:
    """The piece as an episode of LENGTH ticks, simulated by the engine; None when it is not valid."""
    own, other, seat = piece.own.trajectory, piece.other, piece.own.seat
    mine, theirs = slice(piece.start, piece.start + LENGTH), slice(piece.other_start, piece.other_start + LENGTH)
    first = _mixed_state(own, piece.start, other, piece.other_start, seat)
    if first is None:
        return None
    actions = own.actions[mine].copy()
    actions[:, 1 - seat] = other.actions[theirs, 1 - seat]
    levels = np.empty((LENGTH, 2), dtype=np.bool_)
    levels[:, seat] = own.held[mine.start + 1 : mine.stop + 1, seat] >= 0
    levels[:, 1 - seat] = other.held[theirs.start + 1 : theirs.stop + 1, 1 - seat] >= 0
    for robot in (0, 1):
        actions[:, robot, 2] = toggles(levels[:, robot], holding=bool(first.held[robot] >= 0))
    try:
        states = _played(own, first, actions)
    except WorldError:
        return None
    ends = own.robot_poses[mine.stop, seat, :2], other.robot_poses[theirs.stop, 1 - seat, :2]
    reached = states[-1].robot_poses[seat, :2], states[-1].robot_poses[1 - seat, :2]
    strayed = max(float(np.linalg.norm(a - b)) for a, b in zip(ends, reached, strict=True))
    hands = np.array([state.held >= 0 for state in states[1:]])
    if strayed > TOLERANCE or not np.array_equal(hands, levels):
        return None
    return _episode(own, states, actions)


def spliced(piece: RecombinedPiece) -> Trajectory | None:
    """The piece as an episode of LENGTH ticks put together from the two, without the engine: it may be impossible.

    None when both would hold the same item.
    """
    own, other, seat = piece.own.trajectory, piece.other, piece.own.seat
    states = [
        _mixed_state(own, piece.start + tick, other, piece.other_start + tick, seat) for tick in range(LENGTH + 1)
    ]
    known = [state for state in states if state is not None]
    if len(known) < len(states):
        return None
    actions = own.actions[piece.start : piece.start + LENGTH].copy()
    actions[:, 1 - seat] = other.actions[piece.other_start : piece.other_start + LENGTH, 1 - seat]
    return _episode(own, known, actions)


def augmentation(
    parts: Sequence[LearnedPart], count: int, seed: int, matching: Matching = "both-ends", confirm: bool = True
) -> tuple[list[tuple[RecombinedPiece, Trajectory]], RecombinationReport]:
    """Up to `count` random pieces with their episodes, and a report on how many the engine confirms.

    With `confirm`, only confirmed pieces are taken, as the engine plays them; without, all, as `spliced` makes them.
    Pieces that leave the partner's motion unchanged (both stretches end where they started) count as well.
    """
    tried = valid = 0

    def taken() -> Iterator[tuple[RecombinedPiece, Trajectory]]:
        nonlocal tried, valid
        for piece in islice(draw_pieces(parts, seed, matching), TRIES * count):
            tried += 1
            played = recombined(piece)
            valid += played is not None
            trajectory = played if confirm else spliced(piece)
            if trajectory is not None:
                yield piece, trajectory

    found = list(with_progress(islice(taken(), count), count, "recombining"))
    return found, RecombinationReport(tried, valid)


class _Index:
    """Where each stretch of LENGTH ticks starts and ends, for both seats of all episodes; sorted, to be looked up."""

    def __init__(self, trajectories: list[Trajectory], matching: Matching) -> None:
        self.trajectories = trajectories
        self._numbers = {trajectory: number for number, trajectory in enumerate(trajectories)}
        maps: dict[object, int] = {}
        items = max((trajectory.item_poses.shape[1] for trajectory in trajectories), default=0)
        keys: dict[tuple[int, int], list[Indices]] = {}
        for number, trajectory in enumerate(trajectories):
            for seat in (0, 1):
                group = 2 * maps.setdefault(_ground(trajectory.map), len(maps)) + seat
                keys[number, seat] = _keys(trajectory, seat, group, items, matching)
        self._tables = [
            StretchTable({place: each[kind] for place, each in keys.items()})
            for kind in range(2 if matching == "either-end" else 1)
        ]

    def matches(self, trajectory: Trajectory, seat: int, start: int) -> tuple[Indices, Indices]:
        """Episodes (M,) and ticks (M,) at which the seat starts and ends in the same places, in other episodes."""
        number = self._numbers[trajectory]
        found = [table.matches(number, seat, start) for table in self._tables]
        return np.concatenate([walks for walks, _ in found]), np.concatenate([ticks for _, ticks in found])


class StretchTable:
    """Keys of stretches, sorted."""

    def __init__(self, keys: dict[tuple[int, int], Indices]) -> None:
        self._keys = keys
        lengths = [len(each) for each in keys.values()]
        every = np.concatenate([np.empty(0, np.int64), *keys.values()])
        order = np.argsort(every, kind="stable")
        self._sorted = every[order]
        self._walks = np.repeat([number for number, _ in keys], lengths)[order]
        self._ticks = np.concatenate([np.empty(0, np.int64), *map(np.arange, lengths)])[order]

    def matches(self, number: int, seat: int, start: int) -> tuple[Indices, Indices]:
        """Episodes and ticks with the key of a stretch, in other episodes."""
        key = self._keys[number, seat][start]
        rows = slice(*(int(np.searchsorted(self._sorted, key, side)) for side in ("left", "right")))
        others = self._walks[rows] != number
        return self._walks[rows][others], self._ticks[rows][others]


def _ground(the_map: MapSpec) -> object:
    """What two episodes must share: the map, of a variant its walls and goals; its own items stay in each episode."""
    return (the_map.name, the_map.walls, the_map.goals, len(the_map.items)) if the_map.variant else the_map


def _keys(trajectory: Trajectory, seat: int, group: int, items: int, matching: Matching) -> list[Indices]:
    """Keys of the stretches (T + 1 - LENGTH,), equal for the same group and places; two sets for `either-end`."""
    poses = trajectory.robot_poses[:, seat]
    cells = np.clip(np.floor((poses[:, :2] + ARENA_HALF) / CELL), 0, PAPER_CELLS - 1).astype(np.int64)
    eighths = np.round(poses[:, 2] / (2 * np.pi / HEADINGS)).astype(np.int64) % HEADINGS
    sizes = PAPER_CELLS, PAPER_CELLS, HEADINGS, items + 1
    places = np.ravel_multi_index((*cells.T, eighths, trajectory.held[:, seat] + 1), sizes)
    begins, ends, none = places[:-LENGTH], places[LENGTH:], np.zeros(len(places[LENGTH:]), np.int64)
    pairs = {"both-ends": [(begins, ends)], "one-end": [(begins, none)], "either-end": [(begins, none), (none, ends)]}
    count = int(np.prod(sizes))
    return [np.asarray((group * count + first) * count + last, dtype=np.int64) for first, last in pairs[matching]]


def _mixed_state(own: Trajectory, tick: int, other: Trajectory, other_tick: int, seat: int) -> WorldState | None:
    """The state of `own` with the partner of `other`; None when both would hold the same item inconsistently."""

    def mixed(a: Floats, b: Floats) -> Floats:
        both = a.copy()
        both[1 - seat] = b[1 - seat]
        return both

    held = own.held[tick].copy()
    item = int(other.held[other_tick, 1 - seat])
    held[1 - seat] = item
    items = own.item_poses[tick].copy()
    if item >= 0:
        if own.held[tick, seat] == item and own.held[tick, 1 - seat] != item:
            return None
        items[item] = other.item_poses[other_tick, item]
    return WorldState(
        tick=0,
        robot_poses=mixed(own.robot_poses[tick], other.robot_poses[other_tick]),
        robot_velocities=mixed(own.robot_velocities[tick], other.robot_velocities[other_tick]),
        held=held,
        item_poses=items,
    )


def _episode(own: Trajectory, states: Sequence[WorldState], actions: Floats) -> Trajectory:
    """These states and actions, with the map and the names of `own`."""
    return replace(
        own,
        robot_poses=np.array([state.robot_poses for state in states]),
        robot_velocities=np.array([state.robot_velocities for state in states]),
        held=np.array([state.held for state in states]),
        item_poses=np.array([state.item_poses for state in states]),
        actions=actions,
    )


def _played(own: Trajectory, first: WorldState, actions: Floats) -> list[WorldState]:
    """The simulated states of a piece; the first gets its recorded velocities, as the engine starts at rest."""
    world = restage(own.map, first)
    states = [replace(world.state(), robot_velocities=first.robot_velocities)]
    for action in actions:
        world.step(action)
        states.append(world.state())
    return states
