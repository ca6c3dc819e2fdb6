"""Contacts of the robots, as two states show them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from movingout.maps.spec import ROBOT_RADIUS
from movingout.world.constants import COLLISION_SLOP, DRIVE_SPEED
from movingout.world.contact import TOUCHING, collision_speed
from movingout.world.state import WorldState
from tests.world.support import Script


def test_a_contact_is_seen_once_however_long_the_robots_push_each_other() -> None:
    script = Script("HandOff")  # blue at (0, 0), red at (0, -1), both in one lane
    speeds = []
    for _ in range(25):
        before = script.world.state()
        script.step((1.0, math.pi, 0.0), (1.0, 0.0, 0.0))
        speeds.append(collision_speed(before, script.world.state()))
    assert len(hits := [speed for speed in speeds if speed > 0]) == 1
    assert 0 < hits[0] <= 2 * DRIVE_SPEED


def test_robots_that_part_and_meet_again_collide_again() -> None:
    state = Script("HandOff").world.state()

    def apart(gap: float) -> WorldState:
        return replace(state, robot_poses=np.array([[0.0, 2 * ROBOT_RADIUS + gap, 0.0], [0.0, 0.0, 0.0]]))

    near, far = apart(-COLLISION_SLOP), apart(0.05)
    assert collision_speed(far, near) == pytest.approx(0.51)
    assert collision_speed(near, far) == 0 == collision_speed(near, near)
    assert collision_speed(far, apart(2 * TOUCHING)) == 0
