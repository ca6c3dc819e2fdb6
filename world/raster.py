"""A state as a small RGB picture, for image policies, GIF and MP4: 256 x 256, each agent blue in its own view.

Size and colours of the views are the paper's ("Image Observation").
"""

import numpy as np
import numpy.typing as npt
from PIL import Image

from movingout.maps import MapSpec
from movingout.maps.picture import paint_scene
from movingout.maps.scene import LIGHT, SceneState, Theme
from movingout.world.scoring import delivered_items
from movingout.world.state import WorldState

SIDE = 256

Pixels = npt.NDArray[np.uint8]


def picture(map_spec: MapSpec, state: WorldState, seat: int = 0, side: int = SIDE, theme: Theme = LIGHT) -> Image.Image:
    """The state as `seat` sees it: itself blue with a B, the other red with an R. RGB, `side` x `side` pixels."""
    order = [seat, 1 - seat]
    moment = SceneState(
        robots=state.robot_poses[order].tolist(),
        items=state.item_poses.tolist(),
        held=state.held[order].tolist(),
        delivered=delivered_items(map_spec, state.item_poses).tolist(),
    )
    return paint_scene(map_spec, moment, side, theme)


def pixels(map_spec: MapSpec, state: WorldState, seat: int = 0, side: int = SIDE) -> Pixels:
    """The same picture as an array (side, side, 3) of bytes, row 0 at the top."""
    return np.array(picture(map_spec, state, seat, side))
