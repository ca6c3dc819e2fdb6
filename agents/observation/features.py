"""The features of a policy: an observation layout and what the agent remembers; the same live and in training."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.maps import MapSpec
from movingout.world.observation import LAYOUTS, encoder
from movingout.world.observation.memory import (
    MEMORY_ITEMS,
    MEMORY_SIZE,
    Moments,
    memory_block,
    memory_of_the_present,
    memory_signs,
)
from movingout.world.state import Floats, Ints, WorldState

Singles = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class FeatureSet:
    """Which numbers a policy sees: D = the layout's, then a block of memory for each lag."""

    layout: str
    lags: tuple[int, ...] = ()

    @classmethod
    def of(cls, spec: PolicySpec) -> "FeatureSet":
        return cls(spec.layout, spec.lags)

    @property
    def memory_ticks(self) -> int:
        """How far back it looks."""
        return max(self.lags, default=0)

    @property
    def size(self) -> int:
        """D."""
        return LAYOUTS[self.layout].size + len(self.lags) * MEMORY_SIZE

    @property
    def own_frame(self) -> bool:
        return LAYOUTS[self.layout].own_frame

    @property
    def items(self) -> Ints:
        """(7, K) the indices of each item's numbers."""
        layout = LAYOUTS[self.layout]
        starts = [layout.size + MEMORY_SIZE * number for number in range(len(self.lags))]
        blocks = [np.array(MEMORY_ITEMS) + start for start in starts]
        return np.concatenate((np.array(layout.items), *blocks), axis=1)

    @property
    def mirror(self) -> tuple[Ints, Floats] | None:
        """Where each number of mirrored features comes from (D,), and its sign (D,); None without a mirror."""
        mirror = LAYOUTS[self.layout].mirror
        if mirror is None:
            return None
        size = len(mirror[0]) + MEMORY_SIZE * len(self.lags)
        signs = np.concatenate((mirror[1], *[memory_signs()] * len(self.lags)))
        return np.concatenate((mirror[0], np.arange(len(mirror[0]), size))), signs

    @property
    def unchanged(self) -> tuple[Ints, Floats]:
        """Features of a memory in which nothing has changed: where each number comes from (D,), and a factor (D,)."""
        size = LAYOUTS[self.layout].size
        sources, factors = np.arange(self.size), np.ones(self.size)
        present, kept = memory_of_the_present()
        for number in range(len(self.lags)):
            block = slice(size + MEMORY_SIZE * number, size + MEMORY_SIZE * (number + 1))
            sources[block], factors[block] = present, kept
        return sources, factors

    def of_episode(self, the_map: MapSpec, states: tuple[Floats, Floats, Ints, Floats], seat: int) -> Singles | Bytes:
        """Features (T, D) of consecutive states: robot poses and velocities, held items, item poses.

        Pictures are bytes, which the network turns into numbers.
        """
        poses, _, held, items = states
        now = Moments(poses, held, items)
        blocks = [memory_block(now, now.before(lag), seat) for lag in self.lags]
        rows = encoder(the_map, self.layout).encode_arrays(*states, seat)
        if LAYOUTS[self.layout].picture:
            return rows.astype(np.uint8)
        return np.concatenate((rows, *blocks), axis=1).astype(np.float32)

    def of_moments(
        self,
        the_map: MapSpec,
        states: Sequence[WorldState],
        pasts: Sequence[Sequence[WorldState]],
        seats: Sequence[int],
    ) -> Singles:
        """Features (B, D) of unrelated states, each with the states before it, oldest first, and for its own seat."""
        seat = np.array(seats)
        robots, velocities, held = (
            _own_first(rows, seat)
            for rows in (
                np.stack([state.robot_poses for state in states]),
                np.stack([state.robot_velocities for state in states]),
                np.stack([state.held for state in states]),
            )
        )
        items = np.stack([state.item_poses for state in states])
        rows = encoder(the_map, self.layout).encode_arrays(robots, velocities, held, items, seat=0)
        now = Moments(robots, held, items)
        blocks = []
        for lag in self.lags:
            then = [_earlier(state, past, lag) for state, past in zip(states, pasts, strict=True)]
            moments = Moments(
                _own_first(np.stack([state.robot_poses for state in then]), seat),
                _own_first(np.stack([state.held for state in then]), seat),
                np.stack([state.item_poses for state in then]),
            )
            blocks.append(memory_block(now, moments, seat=0))
        return np.concatenate((rows, *blocks), axis=1).astype(np.float32)


def _own_first(rows: npt.NDArray[Any], seat: Ints) -> npt.NDArray[Any]:
    """Rows (B, 2, ...) of blue and red in the order own, partner: no layout knows colours."""
    return np.where((seat == 1).reshape(-1, *[1] * (rows.ndim - 1)), rows[:, ::-1], rows)


def _earlier(state: WorldState, past: Sequence[WorldState], lag: int) -> WorldState:
    """The last state at least `lag` ticks ago, else the oldest there is."""
    old = [one for one in past if one.tick <= state.tick - lag]
    return old[-1] if old else (past[0] if past else state)
