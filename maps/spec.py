"""What a map is: frozen values, no files, no physics.

Units: lengths in arena units (the arena is the square [-1.2, 1.2]², y up), angles in radians (0 looks
along +y, counter-clockwise), masses as the official map files give them.
"""

import importlib
from dataclasses import dataclass, field
from typing import Literal, get_args

Shape = Literal["triangle", "square", "pentagon", "hexagon", "octagon", "circle", "star", "rectangle"]
Size = Literal["small", "middle", "large"]
Mode = Literal["coordination", "awareness", "action consistency", "practice"]

SHAPES: tuple[Shape, ...] = get_args(Shape)
SIZES: tuple[Size, ...] = get_args(Size)
MODES: tuple[Mode, ...] = get_args(Mode)
ARENA_HALF = 1.2  # half the side of the square arena
ROBOT_RADIUS = 0.12
WALL_MARGIN = 0.01  # walls are this much thicker than drawn, on every side
GOAL_MARGIN = 0.05  # a goal accepts this much more than is drawn, on every side
NOTEBOOK_SIDE = 360  # pixels of a map's picture in a notebook
SEAT_COLOURS = ("blue", "red")  # index 0 is the official robot_1, index 1 is robot_2


@dataclass(frozen=True, slots=True)
class Rect:
    """An axis-aligned rectangle by two opposite corners, in the order the map gives them.

    The order matters: the official world makes a wall's four segments from it.
    """

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def left(self) -> float:
        return min(self.x0, self.x1)

    @property
    def right(self) -> float:
        return max(self.x0, self.x1)

    @property
    def bottom(self) -> float:
        return min(self.y0, self.y1)

    @property
    def top(self) -> float:
        return max(self.y0, self.y1)

    def grown(self, margin: float) -> "Rect":
        """The rectangle that reaches `margin` arena units farther on every side; smaller for a negative one."""
        return Rect(self.left - margin, self.bottom - margin, self.right + margin, self.top + margin)


@dataclass(frozen=True, slots=True)
class Pose:
    """A start pose."""

    x: float
    y: float
    angle: float


@dataclass(frozen=True, slots=True)
class ItemSpec:
    """One item: `scale` is the official shape_scale (a circle's radius; other shapes have its area)."""

    id: int
    shape: Shape
    size: Size
    scale: float
    mass: float
    pose: Pose


@dataclass(frozen=True, slots=True)
class MapSpec:
    """A whole map. Hashable, so that what is derived from it can be cached; equal maps may differ in title and text.

    `name` ends with the symmetry when the map is mirrored or turned (`HandOff:mirror:rot90`).
    `variant` is empty for a map as designed and names the randomisation otherwise.
    """

    name: str
    title: str = field(compare=False)
    number: int  # 1-12 as in the paper, 0 for practice and for a user's own maps
    mode: Mode
    description: str = field(compare=False)
    robots: tuple[Pose, Pose]
    walls: tuple[Rect, ...]
    goals: tuple[Rect, ...]
    items: tuple[ItemSpec, ...]
    variant: str = ""

    @property
    def file_name(self) -> str:
        """The name as it can be part of the name of a file or of an episode: `HandOff-mirror` of `HandOff:mirror`."""
        return self.name.replace(":", "-")

    def _repr_svg_(self) -> str:
        """The picture that notebooks show. The module that draws it needs this one, so it is imported on use."""
        svg: str = importlib.import_module("movingout.maps.render").map_svg(self, side=NOTEBOOK_SIDE)
        return svg
