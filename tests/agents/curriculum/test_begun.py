"""A folder that was begun with other sizes is refused, because what is done is not done again."""

import dataclasses
import json
from pathlib import Path

import pytest

from movingout.agents.curriculum import begun
from movingout.agents.curriculum.begun import check_begun, note_begun
from movingout.agents.curriculum.recipe_anywhere import AnywhereSizes
from movingout.agents.errors import DataError
from movingout.agents.partners.families import group


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


def test_a_folder_goes_on_with_a_list_as_long_as_it_names_the_same(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("idle\ngreedy\n")
    sizes = AnywhereSizes(data=tmp_path, partners=f"@{tmp_path / 'mine.txt'}")
    note_begun(sizes)
    (tmp_path / "mine.txt").write_text("# the same\nidle\ngreedy\n")
    check_begun(sizes)
    (tmp_path / "mine.txt").write_text("idle\nporter\n")
    with pytest.raises(DataError) as refused:
        check_begun(sizes)
    assert str(refused.value) == (
        f"{sizes.partners} has changed since {tmp_path}/anywhere was begun with it; choose another --data"
    )
    with pytest.raises(DataError, match=r"was begun with --partners @.*, not --partners AB; choose another --data"):
        check_begun(dataclasses.replace(sizes, partners="AB"))
    (tmp_path / "other.txt").write_text("novice\n")
    with pytest.raises(DataError, match=r"was begun with --partners @.*, not --partners @.*other.txt; choose another"):
        check_begun(dataclasses.replace(sizes, partners=f"@{tmp_path / 'other.txt'}"))


def test_a_folder_begun_before_lists_were_kept_goes_on(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("idle\n")
    sizes = AnywhereSizes(data=tmp_path, partners=f"@{tmp_path / 'mine.txt'}")
    note_begun(sizes)
    note = tmp_path / "anywhere" / "sizes.json"
    note.write_text(
        json.dumps({name: value for name, value in json.loads(note.read_text()).items() if "sha" not in name})
    )
    (tmp_path / "mine.txt").write_text("greedy\n")
    check_begun(sizes)


def test_a_folder_goes_on_as_long_as_the_families_are_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = AnywhereSizes(data=tmp_path)
    note_begun(sizes)
    check_begun(sizes)
    monkeypatch.setattr(begun, "group", lambda name: group(name)[:-1])
    with pytest.raises(DataError, match=r"families has changed since .* was begun with it; choose another --data"):
        check_begun(sizes)


@pytest.mark.parametrize("damage", ["{", "7"])
def test_a_damaged_note_is_said(tmp_path: Path, damage: str) -> None:
    sizes = AnywhereSizes(data=tmp_path)
    note_begun(sizes)
    (tmp_path / "anywhere" / "sizes.json").write_text(damage)
    with pytest.raises(DataError, match=r"cannot read .*sizes.json, which says with what it was begun"):
        check_begun(sizes)
