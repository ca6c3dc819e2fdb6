"""The eight symmetries of the square: maps mirrored and turned, named after the map as in `HandOff:mirror:rot90`.

A symmetry is at most one mirroring, left to right, and then a turn counter-clockwise in quarters. Coordinates are
exact: they only change places and signs. An angle is exact where it is mirrored alone; a turn rounds it once. That is
why several symmetries after one name are joined before they are applied: `HandOff:rot90:rot270` is HandOff to the
last bit.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from movingout.maps.spec import MapSpec, Pose, Rect

SEPARATOR = ":"
MIRROR = "mirror"
TURNS = ("rot90", "rot180", "rot270")
SYMMETRY_NAMES = (MIRROR, *TURNS)


@dataclass(frozen=True, slots=True)
class Symmetry:
    """Mirrored left to right or not, then turned counter-clockwise by 0 to 3 quarters."""

    mirrored: bool = False
    quarters: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """The words of which its name is made; none for the map as designed."""
        return (MIRROR,) * self.mirrored + ((TURNS[self.quarters - 1],) if self.quarters else ())

    def then(self, other: "Symmetry") -> "Symmetry":
        """This symmetry first and the other one after it."""
        turned = -self.quarters if other.mirrored else self.quarters
        return Symmetry(self.mirrored != other.mirrored, (turned + other.quarters) % 4)

    def point(self, x: float, y: float) -> tuple[float, float]:
        """Where a point comes to lie; the same for velocities and other vectors."""
        if self.mirrored:
            x = 0.0 - x  # not -x, which would make -0.0 of 0.0
        for _ in range(self.quarters):
            x, y = 0.0 - y, x
        return x, y

    def angle(self, angle: float) -> float:
        """The angle of a body or of a heading; every shape is its own mirror image at angle 0."""
        if self.mirrored:
            angle = 0.0 - angle
        return math.remainder(angle + self.quarters * (math.pi / 2), math.tau) if self.quarters else angle

    def pose(self, pose: Pose) -> Pose:
        return Pose(*self.point(pose.x, pose.y), self.angle(pose.angle))

    def rect(self, rect: Rect) -> Rect:
        """The same two corners in the same order, each at its new place."""
        return Rect(*self.point(rect.x0, rect.y0), *self.point(rect.x1, rect.y1))


ALL_SYMMETRIES = tuple(Symmetry(mirrored, quarters) for mirrored in (False, True) for quarters in range(4))


def read_symmetry(names: Sequence[str]) -> Symmetry:
    """The symmetry of words of SYMMETRY_NAMES, applied from left to right. Raises KeyError for another word."""
    known = {MIRROR: Symmetry(mirrored=True), **{name: Symmetry(quarters=k) for k, name in enumerate(TURNS, 1)}}
    joined = Symmetry()
    for name in names:
        joined = joined.then(known[name])
    return joined


def split_name(name: str) -> tuple[str, list[str]]:
    """A name without the symmetries at its end, and these."""
    base, *parts = name.split(SEPARATOR)
    names: list[str] = []
    while parts and parts[-1] in SYMMETRY_NAMES:
        names.insert(0, parts.pop())
    return SEPARATOR.join((base, *parts)), names


def transformed(spec: MapSpec, symmetry: Symmetry) -> MapSpec:
    """The map with everything moved by a symmetry, which its name then has at its end."""
    base, before = split_name(spec.name)
    named = read_symmetry(before).then(symmetry)
    blue, red = spec.robots
    return replace(
        spec,
        name=SEPARATOR.join((base, *named.names)),
        robots=(symmetry.pose(blue), symmetry.pose(red)),
        walls=tuple(symmetry.rect(wall) for wall in spec.walls),
        goals=tuple(symmetry.rect(goal) for goal in spec.goals),
        items=tuple(replace(item, pose=symmetry.pose(item.pose)) for item in spec.items),
    )
