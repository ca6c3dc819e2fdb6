"""What a scripted player sees before a tick, put into words that its plans use."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from movingout.agents.scripted.navigation.free_space import FreeSpace, free_space, with_robot
from movingout.agents.scripted.placement.goal_places import PlacementCache
from movingout.agents.scripted.placement.remaining_items import RemainingItems
from movingout.maps import ItemSpec, MapSpec
from movingout.maps.shapes import circumradius
from movingout.world.scoring import delivered_items
from movingout.world.state import Floats, WorldState

FreeSpaceCache = dict[tuple[frozenset[int], bytes], FreeSpace]  # by the items left out and the poses of the others
_FLOORS = 16  # remembered: most stay as they are for many ticks


@dataclass(frozen=True, eq=False)
class Perception:
    """One state from one seat."""

    map: MapSpec
    state: WorldState
    seat: int
    partner_is_still: bool = False  # has not moved for long: better taken for a thing that stands there
    anticipates: bool = True  # plans with what will have been taken away by then, not only with what lies there now
    placements: PlacementCache = field(default_factory=PlacementCache)  # the player's own, through all of an episode
    free_spaces: FreeSpaceCache = field(default_factory=dict)  # likewise

    @property
    def tick(self) -> int:
        return self.state.tick

    @property
    def pose(self) -> Floats:
        """(3,) of the own robot."""
        pose: Floats = self.state.robot_poses[self.seat]
        return pose

    @property
    def partner(self) -> Floats:
        """(3,) of the other robot."""
        pose: Floats = self.state.robot_poses[1 - self.seat]
        return pose

    @property
    def own_item(self) -> int:
        """Index of the item in the own hand, -1 for none."""
        return int(self.state.held[self.seat])

    @property
    def partner_item(self) -> int:
        """Index of the item in the partner's hand, -1 for none."""
        return int(self.state.held[1 - self.seat])

    @property
    def robots(self) -> Floats:
        """(2, 3) poses in seat order."""
        return self.state.robot_poses

    def item(self, index: int) -> ItemSpec:
        """What an item is."""
        return self.map.items[index]

    def item_pose(self, index: int) -> Floats:
        """(3,) where an item is."""
        pose: Floats = self.state.item_poses[index]
        return pose

    def is_heavy(self, index: int) -> bool:
        """Whether an item needs two."""
        return self.map.items[index].size != "small"

    @cached_property
    def delivered(self) -> npt.NDArray[np.bool_]:
        """(N,) which items lie in a goal region."""
        return delivered_items(self.map, self.state.item_poses)

    @cached_property
    def waiting(self) -> list[int]:
        """Items that nobody holds and that are not delivered."""
        held = {self.own_item, self.partner_item}
        return [i for i in range(len(self.map.items)) if i not in held and not self.delivered[i]]

    def remaining(self, item: int) -> RemainingItems:
        """What is still to be delivered besides an item, and who else can do it."""
        others = [other for other in range(len(self.map.items)) if other != item and not self.delivered[other]]
        waiting = [other for other in others if other in self.waiting]
        sizes = [circumradius(self.item(other).shape, self.item(other).scale) for other in others]
        return RemainingItems(
            small=tuple(_point(self.item_pose(other)) for other in waiting if not self.is_heavy(other)),
            heavy=tuple(_point(self.item_pose(other)) for other in waiting if self.is_heavy(other)),
            sizes=tuple(sorted((round(size, 3) for size in sizes), reverse=True)),
            partner=None if self.is_heavy(item) else _point(self.partner),
        )

    def space(self, without: tuple[int, ...] = (), also: tuple[int, ...] = ()) -> FreeSpace:
        """The terrain with every item that nobody holds, except those in `without`, and with those in `also`.

        A partner that stands still stands there too.
        """
        space = self._floor({self.own_item, self.partner_item, *without} - set(also))
        return with_robot(space, self.partner) if self.partner_is_still else space

    def lasting_space(self, without: int) -> FreeSpace:
        """The terrain as it will be: small items that wait are going to be taken away, `without` is in a hand."""
        if not self.anticipates:
            return self.space((without,))
        smalls = (item for item in self.waiting if not self.is_heavy(item))
        return self._floor({self.own_item, self.partner_item, without, *smalls})

    def space_without_delivered(self, without: int) -> FreeSpace:
        """The terrain as if the small items that are delivered were not there."""
        smalls = (item for item in np.flatnonzero(self.delivered).tolist() if not self.is_heavy(item))
        return self._floor({self.own_item, self.partner_item, without, *smalls})

    def _floor(self, skipped: set[int]) -> FreeSpace:
        standing = [index for index in range(len(self.map.items)) if index not in skipped]
        poses = self.state.item_poses[standing]
        key = (frozenset(skipped), poses.tobytes())
        if key not in self.free_spaces:
            if len(self.free_spaces) >= _FLOORS:
                self.free_spaces.clear()
            items = (self.map.items[index] for index in standing)
            placed = [(item, x, y, angle) for item, (x, y, angle) in zip(items, poses.tolist(), strict=True)]
            self.free_spaces[key] = free_space(self.map, tuple(placed))
        return self.free_spaces[key]


def _point(pose: Floats) -> tuple[float, float]:
    return round(float(pose[0]), 1), round(float(pose[1]), 1)
