"""Given episodes of agents alone, and those on other maps, are left out and counted."""

from dataclasses import replace
from pathlib import Path

import pytest

from movingout.maps import load_map, map_names
from movingout.matches.errors import MatchError
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.data_sets import listed_episodes
from movingout.matches.paper.given_choice import with_people
from movingout.matches.paper.given_players import players_of
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import grouped
from tests.agents.learning import recorded

PEOPLE = ("human", "human")


def _two_pairs(folder: Path, **options: object) -> None:
    for name in map_names():
        for one, other in ("ab", "cd"):
            recorded(folder, f"{name}-{one}", 9, people=(one, other), the_map=load_map(name), **options)  # type: ignore[arg-type]


def _listed(folder: Path, challenge: int = 1) -> set[tuple[str, str]]:
    rows = listed_episodes(challenge, Workspace(budget=BUDGETS["smoke"], given=(folder,)))
    return {row.people for row in rows}


def test_agents_alone_are_no_participants_where_others_are_people(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded(tmp_path, "agents", 9, people=("dp@all", "bass@all"))
    recorded(tmp_path, "varied", 9, people=("e", "f"), the_map=replace(load_map("HandOff"), variant="one"))
    _two_pairs(tmp_path, kinds=PEOPLE)
    assert _listed(tmp_path) == {("a", "b"), ("c", "d")}
    why = "nobody but agents plays in them, and other recordings of --data have people"
    assert f"movingout: 1 of 25 episodes cannot be learned from: {why}" in capsys.readouterr().err
    with pytest.raises(MatchError, match="1 of 1 episode cannot be learned from: nobody but agents"):
        _listed(tmp_path, challenge=2)


def test_an_agent_beside_a_replay_is_not_imitated_for_the_person_who_is_replayed(tmp_path: Path) -> None:
    beside = recorded(tmp_path, "beside", 9, people=("ghost:old#blue", "dp@all"), kinds=("ghost", "agent"))
    agents = recorded(tmp_path, "agents", 9, people=("dp@all", "bass@all"))
    person = recorded(tmp_path, "person", 9, people=("ann", "ghost:old#red"), kinds=("human", "ghost"))
    assert with_people([beside, agents], [beside, agents]) == [beside, agents]
    assert players_of(grouped([beside, agents], 1)) == "agents"
    given = [beside, agents, person]
    assert with_people(given, given) == [person] and players_of(grouped([person], 1)) == "people"


def test_recordings_of_agents_alone_are_all_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _two_pairs(tmp_path)
    assert _listed(tmp_path) == {("a", "b"), ("c", "d")} and capsys.readouterr().err == ""


def test_episodes_on_other_maps_than_the_papers_are_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded(tmp_path, "den", 9, people=("e", "f"), the_map=replace(load_map("HandOff"), name="Den"))
    with pytest.raises(MatchError, match="1 of 1 episode cannot be learned from"):
        _listed(tmp_path)
    _two_pairs(tmp_path)
    assert _listed(tmp_path) == {("a", "b"), ("c", "d")}
    said = "1 of 25 episodes cannot be learned from: they are on other maps than the paper's twelve (Den)"
    assert said in capsys.readouterr().err
