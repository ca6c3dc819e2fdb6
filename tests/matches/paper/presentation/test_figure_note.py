"""A table or figure says in itself how it was made and what differs from the paper; settings say nothing of numbers."""

from pathlib import Path

import pytest
from PIL import Image

from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.presentation.drawing import Drawing, save_drawing
from movingout.matches.paper.presentation.figure_note import figure_notes
from movingout.matches.paper.presentation.given_note import SCRIPTED
from movingout.matches.paper.presentation.latex_text import tex
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import grouped, write_groups
from tests.agents.learning import recorded

SPACE = Workspace(budget=BUDGETS["smoke"])
BUDGET = BUDGETS["smoke"].sentence


def test_a_table_says_what_differs_from_the_paper() -> None:
    notes = laid_out(ENTRIES["text:inference_time"], SPACE).notes
    assert "What differs from the paper: on one core of a CPU, with the networks of the budget." in notes
    assert notes[:2] == (BUDGET, SCRIPTED)


@pytest.mark.parametrize("label", ["mappo_parameters", "text:policy_parameters", "text:data_sets", "tab:dense_rewards"])
def test_settings_have_no_budget_and_no_errors(label: str) -> None:
    notes = " ".join(laid_out(ENTRIES[label], SPACE).notes)
    assert "Budget" not in notes and "±" not in notes and "were reproduced" not in notes and notes


def test_sizes_of_given_recordings_say_that_programs_played(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"], given=(tmp_path,))
    files = [recorded(tmp_path, name, 9, people=(name, f"{name}2"), simulated=True) for name in "ab"]
    write_groups(space.listing("c1"), grouped(files, 2))
    said = "Challenge 1: learned from 2 given recordings of 4 participants, in groups of 2 and 2; "
    assert laid_out(ENTRIES["text:data_sets"], space).notes[0].startswith(said + "all by simulated participants")


def test_a_figure_says_whose_episodes_it_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert figure_notes(ENTRIES["fig:rollout_example_task_2"], SPACE)[:2] == (BUDGET, SCRIPTED)
    assert figure_notes(ENTRIES["fig:visual_task1"], SPACE)[:2] == (BUDGET, SCRIPTED)
    assert figure_notes(ENTRIES["fig:visual_task2"], SPACE) == (), "variants of maps need nobody"
    given = Workspace(budget=BUDGETS["smoke"], given=(tmp_path,))
    files = [recorded(tmp_path, name, 9, people=(name, f"{name}2"), kinds=("human", "human")) for name in "ab"]
    write_groups(given.listing("c1"), grouped(files, 2))
    counted = "Challenge 1: learned from 2 given recordings of 4 participants, in groups of 2 and 2."
    assert figure_notes(ENTRIES["fig:visual_task1"], given)[0] == counted, "no budget says how many people played"
    assert figure_notes(ENTRIES["fig:tcl_distance"], given)[:2] == (BUDGET, counted)


def test_all_files_of_a_figure_have_its_notes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    drawing = Drawing(lambda space: Image.new("RGB", (2, 2)))
    save_drawing(drawing, "fig:one", "A title", ("From 90 % of the_data.", "And more."), SPACE)
    assert r"\caption{A title. From 90 \% of the\_data. And more.}" in Path("figures/fig_one.tex").read_text()
    for ending in ("md", "html"):
        assert "From 90 % of the_data. And more." in Path(f"figures/fig_one.{ending}").read_text()


def test_options_in_a_caption_keep_their_hyphens() -> None:
    assert tex("--rigid no, 1 – 2, 90 %") == r"-{}-rigid no, 1 -- 2, 90 \%", "LaTeX makes a dash of two hyphens"
