"""A table says whose recordings it was made from, and that programs are no people."""

from dataclasses import replace
from pathlib import Path

import pytest

from movingout.maps import load_map
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.presentation.given_note import given_notes
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import group_sentences, grouped, write_groups
from tests.agents.learning import recorded


def test_given_recordings_are_counted_and_those_of_a_rehearsal_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"], given=(tmp_path,))
    assert given_notes(space, {1, 2}) == []
    files = [recorded(tmp_path, n, 9, people=(n, f"{n}2"), kinds=("human", "human")) for n in "ab"]
    write_groups(space.listing("c1"), grouped(files, 2))
    varied = replace(load_map("HandOff"), variant="one")
    write_groups(space.listing("c2"), grouped([recorded(tmp_path, "c", 9, the_map=varied, simulated=True)], 1))
    first = "Challenge 1: learned from 2 given recordings of 4 participants, in groups of 2 and 2."
    second = "Challenge 2: learned from 1 given recording of 2 participants; all by simulated participants, who are "
    second += "programs."
    assert given_notes(space, {1, 2}) == [first, second]
    notes = laid_out(ENTRIES["tab:cross_group_eval"], space).notes
    assert first in notes and second not in notes
    assert given_notes(Workspace(budget=BUDGETS["smoke"]), {1, 2}) == []


def test_agents_that_people_played_with_are_no_participants(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"], given=(tmp_path,))
    with_agents = [
        recorded(tmp_path, "one", 9, people=("P1", "bass@all"), kinds=("human", "agent")),
        recorded(tmp_path, "other", 9, people=("bass@all", "P2"), kinds=("agent", "human")),
    ]
    write_groups(space.listing("c1"), rows := grouped(with_agents, 2))
    assert given_notes(space, {1}) == [
        "Challenge 1: learned from 2 given recordings of 2 participants, in groups of 1 and 1."
    ]
    assert [sentence.partition(": ")[2] for sentence in group_sentences(rows)] == ["1 episode of 1 participant"] * 2
    nameless = recorded(tmp_path, "nameless", 9, people=("", ""), kinds=("human", "human"))
    write_groups(space.listing("c1"), grouped([nameless], 1))
    assert given_notes(space, {1}) == ["Challenge 1: learned from 1 given recording of people without a name."]
    half_named = recorded(tmp_path, "half", 9, people=("P1", ""), kinds=("human", "human"))
    write_groups(space.listing("c1"), rows := grouped([nameless, half_named], 1))
    assert group_sentences(rows) == ["group 1: 2 episodes of 1 participant and people without a name"]


def test_agents_alone_are_called_agents(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"], given=(tmp_path,))
    rows = grouped([recorded(tmp_path, name, 9, people=(f"dp@{name}", "bass@all")) for name in "ab"], 1)
    write_groups(space.listing("c1"), rows)
    assert given_notes(space, {1}) == ["Challenge 1: learned from 2 given recordings of 3 agents."]


def test_a_group_of_agents_beside_people_is_called_so(tmp_path: Path) -> None:
    people = recorded(tmp_path, "one", 9, people=("P1", "P2"), kinds=("human", "human"))
    agents = recorded(tmp_path, "other", 9, people=("A01", "A02"), kinds=("agent", "agent"))
    told = {sentence.partition(": ")[2] for sentence in group_sentences(grouped([people, agents], 2))}
    assert told == {"1 episode of 2 participants", "1 episode of agents alone"}
