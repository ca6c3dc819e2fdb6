"""What the shape of a policy may name."""

from typing import get_args

from movingout.agents.checkpoint.policy_spec import LayoutName
from movingout.agents.policies.config import PolicyConfig
from movingout.world.observation import LAYOUTS
from tests.support import ROOT


def test_a_policy_can_see_every_layout_and_help_and_documentation_name_them_all() -> None:
    assert set(get_args(LayoutName)) == set(LAYOUTS)
    said = PolicyConfig.__dataclass_fields__["layout"].metadata["help"]
    page = (ROOT / "docs" / "metrics.md").read_text(encoding="utf-8")
    for name in LAYOUTS:
        assert name in said and f"`{name}`" in page
