"""The maps: what a level is, the 12 of the paper, checking and randomising them."""

from maps.errors import MapError, MovingOutError
from maps.spec import ItemSpec, MapSpec, Pose, Rect

__all__ = ["ItemSpec", "MapError", "MapSpec", "MovingOutError", "Pose", "Rect"]
