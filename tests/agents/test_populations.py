"""Scripted people: the same whenever asked, disjoint between populations, different from each other at play."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from agents.base import ActionChunk, Observation
from agents.catalogue import load_agent
from agents.errors import DataError
from agents.person import Person
from agents.populations import POPULATIONS, manifest, participant, population
from agents.rollout import rollout
from maps import load_map
from recordings import read_episode, verify
from server.cli import main


def test_there_are_three_populations_of_different_people() -> None:
    people = [person for name in POPULATIONS for person in population(name)]
    assert all(len(population(name)) >= 18 for name in POPULATIONS)
    assert len({person.sha256 for person in people}) == len(people)
    assert population("A") == population("A")
    assert manifest()["sha256"] == manifest()["sha256"]


def test_no_style_of_one_population_lies_in_the_region_of_another() -> None:
    speeds = {name: [person.style.speed for person in population(name)] for name in POPULATIONS}
    assert max(speeds["B"]) < min(speeds["C"]) < max(speeds["C"]) < min(speeds["A"])
    orders = {name: {(p.style.heavy_first, p.style.far_first) for p in population(name)} for name in POPULATIONS}
    assert not orders["A"] & orders["B"] and not orders["C"] & (orders["A"] | orders["B"])


def test_a_stranger_is_answered_with_who_there_is() -> None:
    with pytest.raises(DataError, match="A01 to A20"):
        participant("D01")
    with pytest.raises(DataError, match="known: A, B, C"):
        population("D")


def test_people_play_in_their_own_way_and_always_the_same() -> None:
    the_map = load_map("DistancePriority")

    def played(name: str) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        agents = (load_agent(participant(name).agent_id), load_agent("idle"))
        return np.array([step.actions[0] for step in rollout(the_map, agents, 1, 25)])

    assert np.array_equal(played("A01"), played("A01"))
    assert not np.array_equal(played("A01"), played("B01"))
    assert np.abs(played("B01")[:, 0]).max() <= participant("B01").style.speed < 0.9


def test_a_person_sees_the_partner_late() -> None:
    person = Person("C01")
    the_map = load_map("DistancePriority")
    seen: list[float] = []

    def look(observation: Observation) -> ActionChunk:
        seen.append(float(observation.state.robot_poses[1, 0]))
        return np.array([[0.0, 1.0, 0.0, 0.0]])

    person._plan.act = look  # type: ignore[method-assign]
    places = []
    for step in rollout(the_map, (person, load_agent("tests.agents.support:Forward")), 1, 8):
        places.append(step.before.robot_poses[1, 0])
    delay = participant("C01").style.delay
    assert delay == 2 and seen[delay:] == places[:-delay]


def test_demonstrations_are_recordings_that_verify_and_change_seats_after_half(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["demos", "generate", "--population", "A", "--people", "2", "--map", "SingleRotation", "--ticks", "15"]
    command += ["--episodes", "2", "--workers", "1", "--out", str(tmp_path), "--json"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["episodes"] == 2
    episodes = [read_episode(file) for file in sorted(tmp_path.glob("*.mcap"))]
    assert [[seat.name for seat in e.header.seats] for e in episodes] == [["A01", "A02"], ["A02", "A01"]]
    assert all(verify(file).identical for file in tmp_path.glob("*.mcap"))
    assert {e.header.source for e in episodes} == {"scripted"}
    assert json.loads((tmp_path / "people.json").read_text())["sha256"] == manifest()["sha256"]
    assert asdict(participant("A01").style) == manifest()["populations"]["A"][0]["style"]  # type: ignore[index]
    assert main(command) == 0  # what is there is not made again
    assert json.loads(capsys.readouterr().out)["episodes"] == 0
