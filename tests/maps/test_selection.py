"""Which maps are meant by the words of `--map`, and of `map` in Python."""

import re
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


def test_a_list_longer_than_any_name_of_a_file_is_a_list() -> None:
    """A dozen generated maps ended in `OSError: File name too long`."""
    names = [f"generated:coordination:{seed}:hard:mirror" for seed in range(12)]
    assert selected_maps(",".join(names)) == names


@pytest.mark.parametrize("named", ["x" * 300, f"{'x' * 300}:mirro", f"{'x' * 300}.json", "a\0b", "a\0b:mirro"])
def test_a_name_that_no_file_can_have_is_refused_in_a_sentence(named: str) -> None:
    with pytest.raises(MapError):
        load_map(*selected_maps(named))


@pytest.mark.parametrize("named", [None, ["HandOff"], load_map("HandOff")])
def test_what_is_no_name_is_refused_in_a_sentence(named: Any) -> None:
    with pytest.raises(MapError, match="a map is named by its name or the path of its file, not by "):
        selected_maps(named)


def test_a_list_names_whatever_an_option_names(tmp_path: Path) -> None:
    file = tmp_path / "maps.txt"
    file.write_text(
        "# mine\nHandOff:mirror\nmy maps/a,b.json\n\ngenerated:test:2\ngenerated:awareness:12 300\nHandOff:mirror\n"
    )
    named = ["HandOff:mirror", "my maps/a,b.json", *selected_maps("generated:test:2"), "generated:awareness:12"]
    assert selected_maps(f"@{file}") == named
    assert selected_maps(f"@{file}:2,LeftRight") == [*named[:2], "LeftRight"]


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("# nothing\n", "names none"),
        ("HandOff\n@more.txt\n", "line 2: a list names no other list, such as @more.txt"),
        ("generated:awarenes:1 300\n", "unknown maps generated:awarenes:1; did you mean awareness?"),
        ("HandOff\nHandOff # mine\n", "maps.txt, line 2: "),
        ("LeftRight\n\nHandOf\n", "maps.txt, line 3: unknown map 'HandOf'"),
        ("\xff", "is no text in UTF-8"),
    ],
)
def test_a_list_that_names_no_maps_is_refused(content: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "maps.txt").write_text(content, encoding="latin-1")
    with pytest.raises(MapError, match=re.escape(sentence)):
        selected_maps(f"@{tmp_path / 'maps.txt'}")
