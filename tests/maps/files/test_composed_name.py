"""Names of files that one system writes composed and another decomposed: either finds the file."""

import json
import os
from pathlib import Path
from typing import Final, Literal
from unicodedata import normalize

import pytest

from movingout.maps import MapError, load_map, map_to_json
from movingout.maps.files.composed_name import as_stored

Spelling = Literal["NFC", "NFD"]
SPELLINGS: Final[tuple[Spelling, Spelling]] = ("NFC", "NFD")


@pytest.mark.parametrize(("stored", "typed"), [SPELLINGS, SPELLINGS[::-1]])
def test_a_map_is_found_by_the_other_spelling_of_folder_and_name(
    stored: Spelling, typed: Spelling, tmp_path: Path
) -> None:
    folder = tmp_path / normalize(stored, "größe")
    folder.mkdir()
    document = map_to_json(load_map("HandOff")) | {"name": "Den", "number": 0}
    (folder / normalize(stored, "höhle.json")).write_text(json.dumps(document), encoding="utf-8")
    name = normalize(typed, f"{tmp_path}/größe/höhle.json")
    assert not os.path.exists(name), "on this disk, the spellings are two names"
    assert [load_map(one).name for one in (name, f"{name}:mirror")] == ["Den", "Den:mirror"]
    with pytest.raises(MapError, match=r"cannot read the map file .*keine\.json: No such file"):
        load_map(f"{name[: -len('.json')]}-keine.json")


def test_where_both_spellings_are_there_each_is_itself(tmp_path: Path) -> None:
    paths = [str(tmp_path / normalize(spelling, "höhle.json")) for spelling in SPELLINGS]
    for path in paths:
        Path(path).touch()
    assert [as_stored(path) for path in paths] == paths and len({*paths}) == 2
    assert as_stored("./nö/\0") == "./nö/\0"
