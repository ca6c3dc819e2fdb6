"""The observation of one seat, made the same way in a live room, in a match and in training."""

import numpy as np

from movingout.agents.base import Observation
from movingout.maps import MapSpec
from movingout.world.observation import encode_state
from movingout.world.observation.description import Description, described
from movingout.world.ping import HelpPing
from movingout.world.state import Floats, WorldState


def observe(
    map_spec: MapSpec, state: WorldState, seat: int, tick: int | None = None, pings: tuple[HelpPing, ...] = ()
) -> Observation:
    """The observation of `seat` before tick `tick` (default: the state's own tick), with the pings shown then."""

    def encode(layout: str) -> Floats:
        return encode_state(map_spec, state, seat, layout)

    def describe() -> Description:
        return described(map_spec, state, seat)

    return Observation(state, state.tick if tick is None else tick, seat, encode, pings, describe)


def start_state(map_spec: MapSpec) -> WorldState:
    """The state before the first tick, without making a world."""
    return WorldState(
        tick=0,
        robot_poses=np.array([[robot.x, robot.y, robot.angle] for robot in map_spec.robots]),
        robot_velocities=np.zeros((2, 3)),
        held=np.array([-1, -1]),
        item_poses=np.array([[item.pose.x, item.pose.y, item.pose.angle] for item in map_spec.items]).reshape(-1, 3),
    )
