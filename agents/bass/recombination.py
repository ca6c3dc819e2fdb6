"""New episodes' pieces from pairs of episodes: one's own motion from the first, the partner's from the second.

Paper, "Recombination of Sub-Trajectories": where an agent begins and ends a stretch in the same places in two
episodes of a map, what its partner does in one of them also fits the other. Two places are the same when they lie in
the same cell of the 48 x 48 grid, the hand is in the same condition, and the heading in the same eighth of a turn. A
piece is kept only when the engine, started in its first state, goes through it without the two or the walls getting
in each other's way.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from agents.bass.restaging import restage
from agents.dataset import Trajectory
from agents.hold import toggles
from maps.spec import ARENA_HALF
from world.distance import CELL, PAPER_CELLS
from world.errors import WorldError
from world.state import Floats, Ints, WorldState

LENGTH = 8  # ticks of a piece
TOLERANCE = 0.06  # [u] how far the engine may end from the pieces' own ends: joints are made anew
HEADINGS = 8
Matching = Literal["both ends", "one end"]
"""`both ends` is the paper's multi-agent rule; `one end` its single-agent ablation."""


@dataclass(frozen=True, slots=True)
class Piece:
    """A stretch of `own` from tick `start` with the partner of `other` from tick `other_start`."""

    own: int
    start: int
    other: int
    other_start: int
    seat: int  # whose motion is kept


@dataclass(frozen=True, slots=True)
class Report:
    """How many pieces were tried and how many the engine confirmed."""

    tried: int
    valid: int

    @property
    def share(self) -> float:
        return self.valid / self.tried if self.tried else 0.0


def find_pieces(walks: Sequence[Trajectory], seat: int, matching: Matching = "both ends") -> Iterator[Piece]:
    """All pieces of LENGTH ticks among episodes of the same map, in the order of the first episode."""
    keys = [_places(walk, seat) for walk in walks]
    where: dict[tuple[object, ...], list[tuple[int, int]]] = {}
    for index, walk in enumerate(walks):
        for start in range(walk.ticks - LENGTH + 1):
            where.setdefault((walk.map, *_key(keys[index], start, matching)), []).append((index, start))
    for index, walk in enumerate(walks):
        for start in range(walk.ticks - LENGTH + 1):
            for other, other_start in where[(walk.map, *_key(keys[index], start, matching))]:
                if other != index:
                    yield Piece(index, start, other, other_start, seat)


def recombined(walks: Sequence[Trajectory], piece: Piece) -> Trajectory | None:
    """The piece as an episode of LENGTH ticks, played by the engine; None when it is not valid."""
    own, other, seat = walks[piece.own], walks[piece.other], piece.seat
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
    return replace(
        own,
        robot_poses=np.array([state.robot_poses for state in states]),
        robot_velocities=np.array([state.robot_velocities for state in states]),
        held=np.array([state.held for state in states]),
        item_poses=np.array([state.item_poses for state in states]),
        actions=actions,
    )


def augmentation(
    walks: Sequence[Trajectory], count: int, seed: int, matching: Matching = "both ends"
) -> tuple[list[tuple[Trajectory, int]], Report]:
    """Up to `count` valid pieces as (trajectory, seat whose motion is to be learned), drawn at random, and the report.

    Pieces in which the partner does what it did anyway (both stretches end where they began) are as good as others.
    """
    random = np.random.default_rng(seed)
    pieces = [piece for seat in (0, 1) for piece in find_pieces(walks, seat, matching)]
    found: list[tuple[Trajectory, int]] = []
    tried = 0
    for index in random.permutation(len(pieces)):
        if len(found) == count:
            break
        tried += 1
        piece = pieces[index]
        walk = recombined(walks, piece)
        if walk is not None:
            found.append((walk, piece.seat))
    return found, Report(tried, len(found))


def _places(walk: Trajectory, seat: int) -> Ints:
    """(T + 1, 4) column, row, heading eighth, held item of a seat."""
    poses = walk.robot_poses[:, seat]
    cells = np.clip(np.floor((poses[:, :2] + ARENA_HALF) / CELL), 0, PAPER_CELLS - 1)
    eighths = np.round(poses[:, 2] / (2 * np.pi / HEADINGS)) % HEADINGS
    return np.column_stack((cells, eighths, walk.held[:, seat])).astype(np.int64)


def _key(places: Ints, start: int, matching: Matching) -> tuple[object, ...]:
    begin, end = tuple(places[start]), tuple(places[start + LENGTH])
    return (begin, end) if matching == "both ends" else (begin,)


def _mixed_state(own: Trajectory, tick: int, other: Trajectory, other_tick: int, seat: int) -> WorldState | None:
    """Everything from `own`, the partner from `other`; None when the partner holds what is not there."""

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


def _played(own: Trajectory, first: WorldState, actions: Floats) -> list[WorldState]:
    """The states of a piece; the first is as staged."""
    world = restage(own.map, first)
    states = [world.state()]
    for action in actions:
        world.step(action)
        states.append(world.state())
    return states
