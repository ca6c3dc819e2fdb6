"""Two short runs whose end is known to the last bit: one robot carries a small item, two carry a large one.

The expected poses were computed with pymunk 6.11.1 on x86-64 Linux, which replays the official trajectories bit for bit
(tests/world). Small and large items are told apart because they hang on the robots by different joints.
"""

import math
from typing import NamedTuple

import numpy as np

from movingout.maps import load_map
from movingout.world import World

Action = tuple[float, float, float]  # distance, heading [rad], grasp toggle
STILL: Action = (0.0, 0.0, 0.0)
TOGGLE: Action = (0.0, 0.0, 1.0)


class Probe(NamedTuple):
    """A run and where it ends."""

    what: str
    map: str
    actions: tuple[tuple[int, Action, Action], ...]  # ticks, blue, red
    carried: int  # item
    held: tuple[bool, bool]  # by blue, by red
    poses: tuple[float, ...]  # x, y, angle of blue, red and the item at the end


PROBES = (
    Probe(
        what="a small item",
        map="Simple",
        actions=(
            (2, STILL, (1.0, 0.4636476090008061, 0.0)), (1, STILL, TOGGLE), (20, STILL, (1.0, 0.7, 0.0)),
        ),
        carried=1,
        held=(False, True),
        poses=(
            -0.6, -1.0, 0.0,
            -0.17175150099299644, -0.06744217702923994, 0.6999999983234041,
            -0.28686310297657003, 0.06922341306346717, 1.1178731541722293,
        ),
    ),
    Probe(
        what="a large item",
        map="LeftRight",
        actions=(
            (10, (1.0, 0.0, 0.0), STILL), (8, (1.0, -1.5708468572, 0.0), STILL), (1, TOGGLE, STILL),
            (10, STILL, (1.0, 0.0, 0.0)), (9, STILL, (1.0, 1.5713541816, 0.0)), (1, STILL, TOGGLE),
            (12, (1.0, 2.5, 0.0), (1.0, 2.5, 0.0)),
        ),
        carried=1,
        held=(True, True),
        poses=(
            -0.6810913595241941, -0.9111745115572292, -1.0095576150734287,
            -0.1925854096794747, -0.6049604679882533, 2.1326987205770007,
            -0.43708225679384544, -0.7581072049369887, 1.4417179239299556,
        ),
    ),
)  # fmt: skip


def play(probe: Probe) -> tuple[float, ...]:
    """The poses at the end of a run, as `Probe.poses`; empty when the hands do not hold what they should."""
    world = World(load_map(probe.map))
    for ticks, blue, red in probe.actions:
        for _ in range(ticks):
            world.step([blue, red])
    state = world.state()
    if tuple((state.held == probe.carried).tolist()) != probe.held:
        return ()
    poses = np.concatenate([state.robot_poses.ravel(), state.item_poses[probe.carried]])
    return tuple(poses.tolist())


def deviation(probe: Probe) -> float:
    """The largest difference from the known end: 0 where the physics are exact, infinite where a hand let go."""
    poses = play(probe)
    return float(np.abs(np.array(poses) - np.array(probe.poses)).max()) if poses else math.inf
