"""How much of a map a layout holds."""

from typing import NamedTuple

from movingout.maps import MapSpec
from movingout.world.errors import WorldError


class Slots(NamedTuple):
    """The most of each that a vector has numbers for; None where the number does not matter."""

    items: int | None = None
    walls: int | None = None
    goals: int | None = None

    def check(self, map_spec: MapSpec, layout: str) -> None:
        """Raises WorldError for a map that has more of something than the layout of this name has slots."""
        for what, slots in self._asdict().items():
            count = len(getattr(map_spec, what))
            if slots is not None and count > slots:
                raise WorldError(f"the layout {layout} has {slots} slots for {what}; {map_spec.name} has {count}")
