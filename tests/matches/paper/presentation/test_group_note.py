"""A table says how people were divided where that is not as in the paper: two styles, by intent or by chance."""

from dataclasses import replace
from pathlib import Path

import pytest

from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.presentation.group_note import POPULATIONS, STYLES, group_notes
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import grouped, write_groups
from tests.agents.learning import recorded

SPACE = Workspace(budget=BUDGETS["smoke"])


def test_groups_that_were_drawn_as_the_populations_are_say_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert group_notes(SPACE) == [], "nothing is listed yet"
    pairs = [("A01", "A02"), ("A03", "A04"), ("B01", "B02"), ("B03", "B04")]
    files = [recorded(tmp_path / "c1", pair[0], 9, people=pair) for pair in pairs]
    write_groups(SPACE.listing("c1"), grouped(files, 2, seed=0))
    assert group_notes(SPACE) == [POPULATIONS], "as with the budget small"
    assert POPULATIONS in laid_out(ENTRIES["tab:cross_group_eval"], SPACE).notes
    assert POPULATIONS not in laid_out(ENTRIES["fig:results_t2"], SPACE).notes, "nobody there is of a group"
    assert group_notes(replace(SPACE, given=(tmp_path,))) == [], "people have no population"
    assert group_notes(replace(SPACE, grouping="style")) == [STYLES]
    write_groups(SPACE.listing("c1"), grouped(files, 2, seed=1))
    assert group_notes(SPACE) == [], "another draw mixes them"
    files[0].unlink()
    assert group_notes(SPACE) == [], "tables of finished folders need no recordings"
