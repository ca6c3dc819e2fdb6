"""Making the observation that an agent sees, the same in a live room, a match and training; hearing what it says."""

from collections.abc import Mapping

import numpy as np
import orjson

from movingout.agents.base import Agent, Observation
from movingout.maps import MapSpec
from movingout.world.observation import encode_state
from movingout.world.state import Floats, WorldState


def observe(map_spec: MapSpec, state: WorldState, seat: int, tick: int | None = None) -> Observation:
    """The observation of `seat` before tick `tick` (default: the state's own tick)."""

    def encode(layout: str) -> Floats:
        return encode_state(map_spec, state, seat, layout)

    return Observation(state, state.tick if tick is None else tick, seat, encode)


def start_state(map_spec: MapSpec) -> WorldState:
    """The state before the first tick, without making a world."""
    return WorldState(
        tick=0,
        robot_poses=np.array([[robot.x, robot.y, robot.angle] for robot in map_spec.robots]),
        robot_velocities=np.zeros((2, 3)),
        held=np.array([-1, -1]),
        item_poses=np.array([[item.pose.x, item.pose.y, item.pose.angle] for item in map_spec.items]).reshape(-1, 3),
    )


def said(agent: Agent) -> Mapping[str, object]:
    """What the agent says about its last decision: attribute `detail`, a mapping, if it has one, as plain JSON values.

    Arrays become lists. Of what cannot be written as JSON it is said why, under `unwritable`.
    """
    try:
        detail = getattr(agent, "detail", None)
        if not isinstance(detail, Mapping):
            return {}
        plain: dict[str, object] = orjson.loads(orjson.dumps(dict(detail), _plain, orjson.OPT_SERIALIZE_NUMPY))
    except Exception as error:  # noqa: BLE001 - anybody's code is behind it
        return {"unwritable": f"{type(error).__name__}: {error}"[:200]}
    return plain


def _plain(value: object) -> object:
    """For what orjson cannot write itself: arrays that do not lie in one piece."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError
