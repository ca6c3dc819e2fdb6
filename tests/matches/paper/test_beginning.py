"""What a folder of tables was begun with, and what of it may change."""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.matches.commands import paper
from movingout.matches.errors import MatchError
from movingout.matches.paper import data_sets
from movingout.matches.paper.beginning import BEGUN, begin, begun, exclusive_folder, finish, grown
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.data_sets import list_episodes
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import grouped, read_groups, write_groups
from movingout.server.cli import main
from tests.agents.learning import recorded

SMOKE = BUDGETS["smoke"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    yield tmp_path


def _begun(space: Workspace) -> None:
    begin(space)
    space.keep("anything", {})


def test_a_folder_is_of_one_budget(here: Path) -> None:
    _begun(Workspace(budget=SMOKE))
    begin(Workspace(budget=SMOKE))
    with pytest.raises(MatchError, match="was begun with budget smoke; choose another folder with --out"):
        begin(Workspace(budget=BUDGETS["small"]))


def test_trainings_and_matches_may_grow_and_stay_what_they_grew_to(here: Path) -> None:
    assert grown(SMOKE, trainings=None, seeds=None) == SMOKE
    _begun(Workspace(budget=SMOKE))
    begin(more := Workspace(budget=grown(SMOKE, trainings=3, seeds=2)))
    finish(more)
    assert grown(SMOKE, trainings=None, seeds=None) == replace(SMOKE, trainings=3, seeds=2) == begun().budget
    with pytest.raises(MatchError, match="has 3 trainings of each already; --trainings is at least that here"):
        grown(SMOKE, trainings=2)


def test_numbers_that_no_table_was_finished_with_may_be_lowered(here: Path) -> None:
    _begun(first := Workspace(budget=SMOKE))
    begin(Workspace(budget=grown(SMOKE, seeds=20)))
    assert grown(SMOKE).seeds == 20, "which goes on where it was stopped"
    begin(Workspace(budget=grown(SMOKE, seeds=1)))
    finish(first)
    begin(Workspace(budget=grown(SMOKE, seeds=20)))
    assert begun().budget == SMOKE, "a page has what was finished"
    begin(Workspace(budget=grown(SMOKE, seeds=1)))
    finish(Workspace(budget=grown(SMOKE, seeds=2)))
    begin(Workspace(budget=grown(SMOKE, seeds=20)))
    with pytest.raises(MatchError, match="has 2 seeds of each already"):
        grown(SMOKE, seeds=1)


def test_a_table_that_plays_finishes_the_numbers_that_it_was_made_with(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(paper, "carry_out", lambda steps, space, where: None)
    whole = {"trainings": 1, "seeds": 2}
    for label, finished in (("mappo_parameters", {}), ("text:partner_prediction", whole), ("tab:nfd_vs_ac", whole)):
        BEGUN.unlink(missing_ok=True)
        assert main(["paper", "tables", label, "--budget", "smoke", "--seeds", "2", "-o", "."]) == 0
        assert json.loads(BEGUN.read_text(encoding="utf-8"))["finished"] == finished


def test_a_folder_of_an_earlier_version_is_continued(here: Path) -> None:
    old = {"budget": "full", "evaluation": "official", "data": [], "min_tcr": 0.0, "seed": 0}
    BEGUN.write_text(json.dumps(old), encoding="utf-8")
    Workspace(budget=SMOKE).keep("anything", {})
    assert begun().budget == BUDGETS["full"]
    begin(Workspace(budget=BUDGETS["full"]))
    assert json.loads(BEGUN.read_text(encoding="utf-8"))["trainings"] == 3


def test_a_folder_has_groups_of_one_kind(here: Path) -> None:
    styled = Workspace(budget=SMOKE, grouping="style", styles=(("P1", "leads"), ("P2", "follows")))
    _begun(styled)
    assert begun() == styled
    with pytest.raises(MatchError, match="was begun with groups style"):
        begin(Workspace(budget=SMOKE))


def test_recordings_that_changed_since_are_refused(here: Path) -> None:
    recorded(here / "theirs", "one")
    space = Workspace(budget=SMOKE, given=(here / "theirs",))
    _begun(space)
    begin(space)
    recorded(here / "theirs", "two")
    with pytest.raises(MatchError, match=r"the recordings of --data are not those that .* was begun with"):
        begin(space)


def test_recordings_and_folder_may_be_moved(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(data_sets, "map_names", lambda: ("HandOff",))  # of the twelve
    for name in "abcd":
        recorded(here / "theirs", name, 9, people=(name, f"{name}2"))
    space = Workspace(budget=SMOKE, given=(here / "theirs",))
    _begun(space)
    list_episodes(1, space)
    before = [row._replace(path=Path(row.path.name)) for row in read_groups(space.listing("c1"))]
    (here / "theirs").rename(here / "ours")
    moved = replace(space, given=(here / "ours",))
    begin(moved)
    assert begun().given == moved.given
    rows = read_groups(space.listing("c1"))
    assert {row.path.parent.name for row in rows} == {"ours"}
    assert [row._replace(path=Path(row.path.name)) for row in rows] == before
    (here / "ours").rename(here / "hers")
    recorded(here / "hers", "e", 9)
    with pytest.raises(MatchError, match=r"was begun with data .*ours"):
        begin(replace(space, given=(here / "hers",)))


def test_folders_of_recordings_may_change_their_order(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(data_sets, "map_names", lambda: ("HandOff",))  # of the twelve
    for folder, name in (("alpha", "c"), ("alpha", "d"), ("beta", "a"), ("beta", "b")):
        recorded(here / folder, name, 9, people=(name, f"{name}2"))
    space = Workspace(budget=SMOKE, given=(here / "alpha", here / "beta"))
    _begun(space)
    list_episodes(1, space)
    before = [(row.path.name, row.group) for row in read_groups(space.listing("c1"))]
    (here / "alpha").rename(here / "zeta")
    begin(moved := replace(space, given=(here / "zeta", here / "beta")))
    assert [(row.path.name, row.group) for row in read_groups(space.listing("c1"))] == before
    begin(moved)


def test_a_folder_begun_by_an_earlier_version_knows_its_recordings(here: Path) -> None:
    """Whose digest was of names and sizes in the order of folders."""
    for folder, name in (("alpha", "b"), ("beta", "a")):
        recorded(here / folder, name, 9)
    space = Workspace(budget=SMOKE, given=(here / "alpha", here / "beta"))
    _begun(space)
    sizes = [[path.name, path.stat().st_size] for path in space.given_files()]
    digest = hashlib.sha256(json.dumps([sizes, []]).encode()).hexdigest()[:16]
    written = json.loads(BEGUN.read_text(encoding="utf-8"))
    assert written["recordings"] != digest
    BEGUN.write_text(json.dumps({**written, "recordings": digest}), encoding="utf-8")
    begin(space)


def test_a_list_that_would_have_other_groups_stays(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(data_sets, "map_names", lambda: ("HandOff",))
    for name in "ab":
        recorded(here / "theirs", name, 9, people=(name, f"{name}2"))
    space = Workspace(budget=SMOKE, given=(here / "theirs",))
    _begun(space)
    write_groups(space.listing("c1"), grouped(space.given_files(), 1))
    before = space.listing("c1").read_text(encoding="utf-8")
    (here / "theirs").rename(here / "ours")
    with pytest.raises(MatchError, match=r"others or other groups would be learned from than .*c1.csv has"):
        begin(replace(space, given=(here / "ours",)))
    assert space.listing("c1").read_text(encoding="utf-8") == before and begun().given == space.given


def test_the_same_recordings_twice_are_the_same_recordings(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(paper, "carry_out", lambda steps, space, where: None)
    recorded(here / "theirs", "one", 9)
    table = ["paper", "tables", "mappo_parameters", "--budget", "smoke", "-o", "out", "--data", "theirs"]
    assert main(table) == 0 == main([*table, "theirs"])
    assert len(json.loads((here / "out" / BEGUN).read_text(encoding="utf-8"))["data"]) == 1


def test_recordings_that_are_refused_do_not_claim_the_folder(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "notes.md").write_text("no recording", encoding="utf-8")
    recorded(here / "theirs", "one")
    command = ["paper", "tables", "tab:cross_group_eval", "--budget", "smoke", "-o", "out"]
    assert main([*command, "--data", "notes.md"]) == 2
    assert "notes.md is not an MCAP file" in capsys.readouterr().err
    assert main([*command, "--data", "theirs"]) == 2
    assert "2 groups need 2 participants" in capsys.readouterr().err, "not that the folder was begun with other data"


def test_a_link_to_a_recording_that_is_gone_is_named(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "data").mkdir()
    (here / "data/gone.mcap").symlink_to("nowhere")
    assert main(["paper", "tables", "tab:cross_group_eval", "--data", "data", "--dry-run", "-o", "out"]) == 2
    assert "data/gone.mcap: there is no such file; correct --data, or remove a broken link" in capsys.readouterr().err


def test_a_second_command_in_the_same_folder_is_told_to_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ["paper", "tables", "tab:dense_rewards", "--budget", "smoke", "-o", str(tmp_path)]
    with exclusive_folder():
        assert main(asked) == 2
    assert f"another `movingout paper` is at work in {tmp_path}; wait for it" in capsys.readouterr().err
    assert main(asked) == 0
