"""Randomised maps that were made ahead: one takes a third of a second or, where a map is tight, much longer, and a room
has a tenth of a second between two ticks."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterator
from typing import TypeVar

from movingout.maps import MapError, MapSpec, MovingOutError
from movingout.maps.randomize import Split, randomize

log = logging.getLogger(__name__)

KEPT = 500

Kept = TypeVar("Kept")
Variant = tuple[MapSpec, int, Split]  # a designed map, the seed of its changes, and which shapes they may have


class PreparedMaps:
    """The newest `KEPT` of them. `make` makes one in another process, where a round misses it."""

    def __init__(self, make: Callable[[MapSpec, int, Split], Awaitable[MapSpec]] | None = None) -> None:
        self._make = make
        self._made: dict[Variant, MapSpec] = {}  # in the order made
        self._making: dict[Variant, asyncio.Task[None]] = {}
        self._failed: dict[Variant, str] = {}  # why there is none

    def __contains__(self, variant: Variant) -> bool:
        return variant in self._made

    def __iter__(self) -> Iterator[tuple[Variant, MapSpec]]:
        return iter(self._made.items())

    def keep(self, variant: Variant, made: MapSpec) -> None:
        """Drops the oldest. What could not be made before is there now."""
        self._failed.pop(variant, None)
        _keep(self._made, variant, made)

    def is_ready(self, designed: MapSpec, seed: int | None, split: Split) -> bool:
        """Whether `world_map` has nothing to make; what is missing is being made from now on.

        Raises MapError where it could not be made.
        """
        if seed is None or self._make is None or (variant := (designed, seed, split)) in self._made:
            return True
        if variant in self._failed:
            raise MapError(self._failed[variant])
        if variant not in self._making:
            self._making[variant] = asyncio.create_task(self._make_missing(variant, self._make(*variant)))
        return False

    async def prepare(self, designed: MapSpec, seed: int | None, split: Split) -> None:
        """Wait until `is_ready`. Raises MapError where it could not be made."""
        if seed is not None and not self.is_ready(designed, seed, split):
            await self._making[designed, seed, split]
            self.is_ready(designed, seed, split)

    def world_map(self, designed: MapSpec, seed: int | None, split: Split) -> MapSpec:
        """The map as designed where there is no seed, else its variant: prepared, or made now.

        Raises MapError where it has none; what could not be made elsewhere is not tried again.
        """
        if seed is None:
            return designed
        variant = designed, seed, split
        if variant in self._failed:
            raise MapError(self._failed[variant])
        made = self._made.get(variant)
        return randomize(*variant) if made is None else made

    async def _make_missing(self, variant: Variant, made: Awaitable[MapSpec]) -> None:
        try:
            self.keep(variant, await made)
        except MovingOutError as error:
            log.warning("%s is not varied with the seed %d: %s", variant[0].name, variant[1], error)
            _keep(self._failed, variant, str(error))
        except Exception as error:  # of any kind: the room ends its series, and nobody tries it at each tick
            log.exception("%s is not varied with the seed %d", variant[0].name, variant[1])
            _keep(self._failed, variant, str(error))
        finally:
            del self._making[variant]


def _keep(kept: dict[Variant, Kept], variant: Variant, value: Kept) -> None:
    kept.pop(variant, None)  # what is kept again is the newest
    kept[variant] = value
    while len(kept) > KEPT:
        del kept[next(iter(kept))]
