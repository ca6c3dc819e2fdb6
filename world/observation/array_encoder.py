"""What layouts share that encode whole episodes as arrays: a state is an episode of one tick."""

from abc import ABC, abstractmethod

from movingout.world.state import Floats, Ints, WorldState


class ArrayEncoder(ABC):
    """Encodes the states of one map in a layout of D numbers, from `encode_arrays` alone."""

    @abstractmethod
    def encode_arrays(
        self, robot_poses: Floats, robot_velocities: Floats, held: Ints, item_poses: Floats, seat: int
    ) -> Floats:
        """The vectors (T, D) of states given as arrays: (T, 2, 3), (T, 2, 3), (T, 2) and (T, N, 3)."""

    def encode(self, state: WorldState, seat: int) -> Floats:
        """The vector (D,) that `seat` sees."""
        rows = self.encode_arrays(
            state.robot_poses[None], state.robot_velocities[None], state.held[None], state.item_poses[None], seat
        )
        vector: Floats = rows[0]
        return vector

    def encode_both(self, state: WorldState) -> tuple[Floats, Floats]:
        """What blue and red see, (D,) each."""
        return self.encode(state, 0), self.encode(state, 1)
