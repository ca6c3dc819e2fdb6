"""A world started from a given state, as closely as the engine allows.

Poses are exact; grasps are made again, which takes one tick; velocities start at zero. Use `World.snapshot` for exact
copies; this is for states without a history, such as recombined ones.
"""

from dataclasses import replace

import numpy as np

from movingout.maps import MapSpec
from movingout.maps.spec import Pose
from movingout.world import World
from movingout.world.errors import WorldError
from movingout.world.state import WorldState


def restage(map_spec: MapSpec, state: WorldState) -> World:
    """A world of the same map with the poses and grasps of `state`.

    Raises WorldError when a hand cannot reach the item it should hold.
    """
    poses = [Pose(*row) for row in state.item_poses.tolist()]
    blue, red = (Pose(*row) for row in state.robot_poses.tolist())
    items = tuple(replace(item, pose=pose) for item, pose in zip(map_spec.items, poses, strict=True))
    world = World(replace(map_spec, robots=(blue, red), items=items), record_sub_poses=False)
    holding = state.held >= 0
    if holding.any():
        world.step(np.column_stack((np.zeros(2), state.robot_poses[:, 2], holding)))
    if not np.array_equal(world.state().held, state.held):
        raise WorldError("this state cannot be restored: a hand does not reach the item it should hold")
    return world
