"""The map that docs/maps.md shows must be one that works."""

import json

import pytest

from movingout.maps import map_from_json
from movingout.maps.check import check_map
from tests.support import ROOT


@pytest.mark.slow
def test_the_documented_map_can_be_played() -> None:
    text = (ROOT / "docs" / "maps.md").read_text(encoding="utf-8")
    spec = map_from_json(json.loads(text.split("```json")[1].split("```")[0]))
    assert check_map(spec) == ()
