"""What every layout says of itself is so: who learns, exports and adapts policies goes by it."""

from dataclasses import replace

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.world.observation import LAYOUTS, encode_state
from movingout.world.state import Floats, WorldState
from tests.support import ROOT
from tests.world.states import start_of

MAP = load_map("HandOff")
STATE = replace(
    start_of(MAP),
    robot_poses=np.array([[0.3, -0.2, 0.4], [-0.5, 0.1, 2.0]]),
    robot_velocities=np.array([[0.1, 0.2, 0.3], [-0.2, 0.4, -0.5]]),
)
NUMBERS = [name for name, layout in LAYOUTS.items() if not layout.picture]


def _changed(state: WorldState, layout: str) -> set[int]:
    """Which numbers of blue are others in `state` than in STATE."""
    return set(np.flatnonzero(encode_state(MAP, state, 0, layout) != encode_state(MAP, STATE, 0, layout)).tolist())


def _moved(poses: Floats, row: int) -> Floats:
    moved = poses.copy()
    moved[row] += [0.05, -0.04, 0.3]
    return moved


def test_sizes_differ_because_the_layout_of_a_file_is_known_by_its_size() -> None:
    assert len({layout.size for layout in LAYOUTS.values()}) == len(LAYOUTS)


@pytest.mark.parametrize("name", NUMBERS)
def test_the_first_numbers_are_the_own_robot_and_the_next_its_partner(name: str) -> None:
    own = LAYOUTS[name].own_numbers
    assert own
    partner = _changed(replace(STATE, robot_poses=_moved(STATE.robot_poses, 1)), name)
    assert min(partner) >= own and partner & set(range(own, 2 * own))
    items = _changed(replace(STATE, item_poses=_moved(STATE.item_poses, 0)), name)
    assert items and min(items) >= 2 * own
    for holds in (-1, 0):  # what learns from hands that change looks there
        assert encode_state(MAP, replace(STATE, held=np.array([holds, -1])), 0, name)[4] == (1 if holds == 0 else -1)


@pytest.mark.parametrize("name", NUMBERS)
def test_where_the_partner_is_said_to_be_it_is(name: str) -> None:
    layout, seen = LAYOUTS[name], encode_state(MAP, STATE, 0, name)
    own, (x, y, angle) = STATE.robot_poses
    assert (layout.partner_pose is None) == layout.own_frame
    if layout.partner_pose is not None:
        pose = seen[layout.partner_pose : layout.partner_pose + 4]
        np.testing.assert_allclose(pose, [x, y, np.cos(angle), np.sin(angle)], atol=1e-12)
    if layout.partner_offset is not None:
        np.testing.assert_allclose(seen[layout.partner_offset :][:2], [x - own[0], y - own[1]], atol=1e-12)


def test_the_pages_name_every_layout_with_its_size_and_what_it_holds() -> None:
    policies, maps = ((ROOT / "docs" / page).read_text(encoding="utf-8") for page in ("agents.md", "maps.md"))
    for layout in LAYOUTS.values():
        assert f"`{layout.name}` ({layout.size:,}" in " ".join(policies.split())
        assert layout.slots.goals is None or f"`{layout.name}`" in maps
