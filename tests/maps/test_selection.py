"""Which maps are meant by the words of `--map`, and of `map` in Python."""

from pathlib import Path
from typing import Any

import pytest

from movingout.maps import load_map
from movingout.maps.errors import MapError
from movingout.maps.selection import selected_maps


def test_a_map_that_is_named_twice_is_meant_once() -> None:
    """Its second episode was a copy of the first, and counted."""
    assert selected_maps("HandOff,LeftRight,HandOff") == ["HandOff", "LeftRight"]


def test_a_path_is_a_map(tmp_path: Path) -> None:
    file = tmp_path / "a,b.json"
    file.write_text("{}")
    assert selected_maps(file) == [str(file)]


@pytest.mark.parametrize("named", [None, ["HandOff"], load_map("HandOff")])
def test_what_is_no_name_is_refused_in_a_sentence(named: Any) -> None:
    with pytest.raises(MapError, match="a map is named by its name or the path of its file, not by "):
        selected_maps(named)
