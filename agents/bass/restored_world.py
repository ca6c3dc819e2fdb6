"""A world that begins in the middle: in a given state, as nearly as the engine lets one set it.

Poses are exact; hands close anew, which takes one tick; velocities start at zero. For an exact moment use
`World.snapshot`; this is for states of which no history is known, such as recombined ones.
"""

from dataclasses import replace

import numpy as np

from movingout.maps import MapSpec
from movingout.maps.spec import Pose
from movingout.world import World
from movingout.world.errors import WorldError
from movingout.world.state import WorldState


def restage(map_spec: MapSpec, state: WorldState) -> World:
    """A world of the same map in which robots and items stand as in `state`, and hands hold what they hold there.

    Raises WorldError when a hand does not reach what it should hold.
    """
    poses = [Pose(*row) for row in state.item_poses.tolist()]
    blue, red = (Pose(*row) for row in state.robot_poses.tolist())
    items = tuple(replace(item, pose=pose) for item, pose in zip(map_spec.items, poses, strict=True))
    world = World(replace(map_spec, robots=(blue, red), items=items), record_sub_poses=False)
    holding = state.held >= 0
    if holding.any():
        world.step(np.column_stack((np.zeros(2), state.robot_poses[:, 2], holding)))
    if not np.array_equal(world.state().held, state.held):
        raise WorldError("this state cannot be staged anew: a hand does not reach what it should hold")
    return world
