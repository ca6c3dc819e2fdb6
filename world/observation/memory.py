"""What a seat remembers: where robots and items were some ticks ago, in its present frame.

One block of numbers per lag, for agents that see `relative-v1` and play on what happened in the last seconds. It is no
layout of its own, because it takes more than one state.

| index in a block | what |
|---|---|
| 0-2 | own position then minus now (ahead, left), own hand then: +1 or -1 |
| 3-7 | the partner's position then minus now, its heading then, its hand then |
| 8 + 4 i | item i (i = 0-6): its position then minus now, held by oneself then, by the partner then |
"""

from typing import NamedTuple

import numpy as np

from movingout.world.observation.relative import (
    OWN_HAND,
    PARTNER_HAND,
    PARTNER_HEADING,
    RELATIVE_ITEMS,
    Frame,
)
from movingout.world.state import Floats, Ints

_ITEM_SLOTS, _BODIES, _ITEM = 7, 8, 4
MEMORY_SIZE = _BODIES + _ITEM_SLOTS * _ITEM
MEMORY_ITEMS = tuple(tuple(range(_BODIES + slot * _ITEM, _BODIES + (slot + 1) * _ITEM)) for slot in range(_ITEM_SLOTS))
"""Indices (7, 4) of each item's numbers in a block."""
_SIDEWAYS = (1, 4, 6, *(item[1] for item in MEMORY_ITEMS))


class Moments(NamedTuple):
    """States as arrays: robot poses (T, 2, 3), held items (T, 2), item poses (T, N, 3)."""

    robot_poses: Floats
    held: Ints
    item_poses: Floats

    def at(self, rows: Ints) -> "Moments":
        """The states of some rows (T,)."""
        return Moments(self.robot_poses[rows], self.held[rows], self.item_poses[rows])

    def before(self, lag: int) -> "Moments":
        """Consecutive states each `lag` ticks earlier, the first one where there is none so early."""
        return self.at(np.maximum(np.arange(len(self.held)) - lag, 0))


def memory_block(now: Moments, then: Moments, seat: int) -> Floats:
    """(T, 36) what `seat` remembers of `then` in the states `now`."""
    ticks, count = now.item_poses.shape[:2]
    frame, other = Frame(now.robot_poses[:, seat, 2]), 1 - seat
    moved = frame(then.robot_poses[..., :2] - now.robot_poses[..., :2])
    hands = np.where(then.held >= 0, 1.0, -1.0)
    angle = then.robot_poses[:, other, 2]
    heading = frame(np.stack((-np.sin(angle), np.cos(angle)), axis=-1))
    bodies = moved[:, seat], hands[:, seat, None], moved[:, other], heading, hands[:, other, None]
    index = np.arange(count)
    holds = np.stack((then.held[:, seat, None] == index, then.held[:, other, None] == index), axis=-1)
    items = np.zeros((ticks, _ITEM_SLOTS, _ITEM))
    items[:, :count] = np.concatenate((frame(then.item_poses[..., :2] - now.item_poses[..., :2]), holds), axis=-1)
    return np.concatenate((*bodies, items.reshape(ticks, -1)), axis=1)


def memory_of_the_present() -> tuple[Ints, Floats]:
    """A block in which nothing has changed: which number of `relative-v1` each is (36,), and its factor, 0 or 1."""
    sources, factors = np.zeros(MEMORY_SIZE, dtype=np.int64), np.zeros(MEMORY_SIZE)
    sources[[2, 5, 6, 7]] = [OWN_HAND, *PARTNER_HEADING, PARTNER_HAND]
    for block, item in zip(MEMORY_ITEMS, RELATIVE_ITEMS, strict=True):
        sources[list(block[2:])] = item[2], item[3]
        factors[list(block[2:])] = 1.0
    factors[[2, 5, 6, 7]] = 1.0
    return sources, factors


def memory_signs() -> Floats:
    """(36,) -1 for the numbers of a block that change sign in a mirror."""
    signs = np.ones(MEMORY_SIZE)
    signs[list(_SIDEWAYS)] = -1.0
    return signs
