"""Noise on the partner's pose goes where a layout has that pose, and nowhere else."""

from dataclasses import replace

import pytest
import torch

from movingout.agents.policies.pose_noise import noisy_partner
from movingout.world.observation import LAYOUTS, Layout


@pytest.mark.parametrize(
    ("layout", "changed"),
    [
        (LAYOUTS["official-v1"], {8, 9, 10, 11}),
        (LAYOUTS["map-v1"], {8, 9, 10, 11}),
        (LAYOUTS["aware-v1"], {8, 9, 10, 11, 169, 170}),
        (replace(LAYOUTS["map-v1"], name="longer-v1", size=200), {8, 9, 10, 11}),
        (replace(LAYOUTS["map-v1"], name="other-v1", partner_pose=2, partner_offset=50), {2, 3, 4, 5, 50, 51}),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_only_the_numbers_of_the_partner_change(layout: Layout, changed: set[int]) -> None:
    torch.manual_seed(0)
    seen = torch.randn(3, 2, layout.size)
    noisy, pose = noisy_partner(seen, 0.1, layout), layout.partner_pose
    assert pose is not None
    assert set((noisy != seen).any(dim=0).any(dim=0).nonzero().flatten().tolist()) == changed
    shift = (noisy - seen)[..., pose : pose + 2]
    torch.testing.assert_close(shift[:, :1].expand_as(shift), shift, atol=1e-6, rtol=0)  # the same in a window
