"""The layout `image-v1`: a picture of the arena, 128 x 128 RGB, in which each agent is blue in its own view.

The paper draws 256 x 256 ("Image Observation"); half of that keeps what an item is and costs a quarter. Drawn with
`world.raster`. Numbers are bytes, 0 to 255, row by row from the top, red, green and blue of each pixel in turn.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.maps import MapSpec
from movingout.world.state import Floats, Ints, WorldState

PICTURE_LAYOUT = "image-v1"
PICTURE_SIDE = 128  # pixels
PICTURE_SHAPE = (PICTURE_SIDE, PICTURE_SIDE, 3)
PICTURE_SIZE = PICTURE_SIDE * PICTURE_SIDE * 3


def picture_bounds() -> Floats:
    return np.full(PICTURE_SIZE, 255.0)


class PictureEncoder:
    """Draws the states of one map."""

    def __init__(self, map_spec: MapSpec) -> None:
        from movingout.world.raster import pixels  # Pillow is loaded where pictures are wanted

        self.map = map_spec
        self._pixels = pixels

    def encode(self, state: WorldState, seat: int) -> Floats:
        """The picture (49152,) that `seat` sees."""
        return self._drawn(state, seat).astype(np.float64)

    def encode_both(self, state: WorldState) -> tuple[Floats, Floats]:
        return self.encode(state, 0), self.encode(state, 1)

    def encode_arrays(
        self, robot_poses: Floats, robot_velocities: Floats, held: Ints, item_poses: Floats, seat: int
    ) -> npt.NDArray[Any]:
        """The pictures (T, 49152) as bytes: an episode of them has 25 MB."""
        drawn = np.empty((len(robot_poses), PICTURE_SIZE), dtype=np.uint8)
        for tick, rows in enumerate(zip(robot_poses, robot_velocities, held, item_poses, strict=True)):
            poses, velocities, hands, items = rows
            drawn[tick] = self._drawn(WorldState(tick, poses, velocities, hands, items), seat)
        return drawn

    def _drawn(self, state: WorldState, seat: int) -> npt.NDArray[np.uint8]:
        return self._pixels(self.map, state, seat, PICTURE_SIDE).reshape(-1)
