"""What a scripted agent perceives before a tick, in the terms that its planning uses."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from movingout.agents.scripted.navigation.free_space import FreeSpace, free_space, with_robot
from movingout.agents.scripted.partner_intent import PartnerIntent
from movingout.agents.scripted.placement.goal_places import PlacementCache
from movingout.agents.scripted.placement.remaining_items import RemainingItems
from movingout.maps import ItemSpec, MapSpec
from movingout.maps.shapes import circumradius
from movingout.world.scoring import delivered_items
from movingout.world.state import Floats, WorldState

FreeSpaceCache = dict[tuple[frozenset[int], bytes], FreeSpace]  # by (items left out, poses of the others)
_FLOORS = 16  # kept: items rarely move, so most are used for many ticks


@dataclass(frozen=True, eq=False)
class Perception:
    """A world state as seen from one seat."""

    map: MapSpec
    state: WorldState
    seat: int
    partner_is_still: bool = False  # has not moved for long: plan around it as an obstacle
    anticipates: bool = True  # plan for items that will have been moved by then
    placements: PlacementCache = field(default_factory=PlacementCache)  # the agent's own, for a whole episode
    free_spaces: FreeSpaceCache = field(default_factory=dict)  # the same
    intent: PartnerIntent | None = None  # what the partner means; None for an agent that takes it for its like

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
        """Index of the item in the own gripper, -1 for none."""
        return int(self.state.held[self.seat])

    @property
    def partner_item(self) -> int:
        """Index of the item in the partner's gripper, -1 for none."""
        return int(self.state.held[1 - self.seat])

    @property
    def robots(self) -> Floats:
        """(2, 3) poses in seat order."""
        return self.state.robot_poses

    def item(self, index: int) -> ItemSpec:
        """Size and shape of an item."""
        return self.map.items[index]

    def item_pose(self, index: int) -> Floats:
        """(3,) pose of an item."""
        pose: Floats = self.state.item_poses[index]
        return pose

    def is_heavy(self, index: int) -> bool:
        """Whether an item needs two robots."""
        return self.map.items[index].size != "small"

    @cached_property
    def delivered(self) -> npt.NDArray[np.bool_]:
        """(N,) which items lie in a goal."""
        return delivered_items(self.map, self.state.item_poses)

    @cached_property
    def waiting(self) -> list[int]:
        """The items that are neither held nor delivered."""
        held = {self.own_item, self.partner_item}
        return [i for i in range(len(self.map.items)) if i not in held and not self.delivered[i]]

    def remaining(self, item: int) -> RemainingItems:
        """The items still to be delivered apart from `item`, and the partner that can help."""
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
        """Free space with all items that are not held as obstacles, except those in `without`, plus those in `also`.

        A partner that stands still is an obstacle, too.
        """
        space = self._floor({self.own_item, self.partner_item, *without} - set(also))
        return with_robot(space, self.partner) if self.partner_is_still else space

    def lasting_space(self, without: int) -> FreeSpace:
        """Free space as it will be: without the small items still to be delivered, and without the item `without`."""
        if not self.anticipates:
            return self.space((without,))
        smalls = (item for item in self.waiting if not self.is_heavy(item))
        return self._floor({self.own_item, self.partner_item, without, *smalls})

    def space_without_delivered(self, without: int) -> FreeSpace:
        """Free space without the small items that are delivered, and without the item `without`."""
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
