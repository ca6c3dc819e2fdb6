"""The vocabulary of the whole system: what the world looks like at one instant."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class WorldState:
    """A copy of the world after `tick` steps; nothing in it changes any more.

    Angles are in radians and not wrapped. Index 0 is blue, 1 is red.
    """

    tick: int
    robot_poses: Floats  # (2, 3) x, y, angle
    robot_velocities: Floats  # (2, 3) vx, vy [units/s], angular [rad/s]
    held: Ints  # (2,) index into the items, -1 for none
    item_poses: Floats  # (N, 3) x, y, angle

    def copy(self) -> "WorldState":
        """The same with arrays of its own: for code of others, which may write into what it is given."""
        return WorldState(
            self.tick,
            self.robot_poses.copy(),
            self.robot_velocities.copy(),
            self.held.copy(),
            self.item_poses.copy(),
        )
