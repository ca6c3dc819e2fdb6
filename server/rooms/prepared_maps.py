"""Randomised maps that were made ahead: one takes a third of a second, more than a room has between two ticks."""

from collections.abc import Iterator

from movingout.maps import MapSpec
from movingout.maps.randomize import Split, randomize

KEPT = 500

Variant = tuple[MapSpec, int, Split]  # a designed map, the seed of its changes, and which shapes they may have


class PreparedMaps:
    """The newest `KEPT` of them."""

    def __init__(self) -> None:
        self._made: dict[Variant, MapSpec] = {}  # in the order made

    def __contains__(self, variant: Variant) -> bool:
        return variant in self._made

    def __iter__(self) -> Iterator[tuple[Variant, MapSpec]]:
        return iter(self._made.items())

    def keep(self, variant: Variant, made: MapSpec) -> None:
        """Drops the oldest."""
        self._made[variant] = made
        while len(self._made) > KEPT:
            del self._made[next(iter(self._made))]

    def world_map(self, designed: MapSpec, seed: int | None, split: Split) -> MapSpec:
        """The map as designed where there is no seed, else its variant: prepared, or made now."""
        if seed is None:
            return designed
        variant = self._made.get((designed, seed, split))
        return randomize(designed, seed, split) if variant is None else variant
