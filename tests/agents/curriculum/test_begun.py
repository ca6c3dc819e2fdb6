"""A folder that was begun with other sizes is refused, because what is done is not done again."""

import dataclasses
from pathlib import Path

import pytest

from movingout.agents.curriculum.begun import check_begun, note_begun
from movingout.agents.curriculum.recipe_anywhere import AnywhereSizes
from movingout.agents.errors import DataError


def test_a_folder_goes_on_with_its_own_sizes_alone(tmp_path: Path) -> None:
    sizes = AnywhereSizes(data=tmp_path)
    check_begun(sizes)
    note_begun(sizes)
    check_begun(sizes)
    check_begun(dataclasses.replace(sizes, workers=5, seeds=3, response_rounds=7))
    others = dataclasses.replace(sizes, partners="AB", paper_maps=True)
    note_begun(others)  # keeps what is there
    with pytest.raises(DataError) as refused:
        check_begun(others)
    assert str(refused.value) == (
        f"{tmp_path}/anywhere was begun with --partners families no --paper-maps, not --partners AB --paper-maps; "
        "choose another --data"
    )
    check_begun(dataclasses.replace(others, data=tmp_path / "other"))


@pytest.mark.parametrize("damage", ["{", "7"])
def test_a_damaged_note_is_said(tmp_path: Path, damage: str) -> None:
    sizes = AnywhereSizes(data=tmp_path)
    note_begun(sizes)
    (tmp_path / "anywhere" / "sizes.json").write_text(damage)
    with pytest.raises(DataError, match=r"cannot read .*sizes.json, which says with what it was begun"):
        check_begun(sizes)
