"""Scripted people: the same whenever asked, disjoint between populations, different from each other at play."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.base import ActionChunk, Observation
from movingout.agents.catalogue import load_agent
from movingout.agents.data.corrections import load_correction
from movingout.agents.data.rollout import rollout
from movingout.agents.errors import AgentError, DataError
from movingout.agents.scripted.human_model import HumanModel
from movingout.agents.scripted.keyboard_model import KeyboardModel
from movingout.agents.scripted.populations import POPULATIONS, manifest, population, scripted_person
from movingout.maps import load_map
from movingout.recordings import read_episode, verify
from movingout.server.cli import main
from movingout.world import World
from movingout.world.scoring import delivered_items


def test_there_are_three_populations_of_different_people() -> None:
    people = [person for name in POPULATIONS for person in population(name)]
    assert all(len(population(name)) >= 18 for name in POPULATIONS)
    assert len({person.sha256 for person in people}) == len(people)
    assert population("A") == population("A")
    assert str(manifest()["sha256"]).startswith("dd8f8c9443d055dd")  # on them rests every score that was published


def test_no_style_of_one_population_lies_in_the_region_of_another() -> None:
    apart = ("speed", "patience", "detour", "help_after", "handover", "side", "delay", "noise")
    for habit in apart:
        ranges = {name: [getattr(person.style, habit) for person in population(name)] for name in POPULATIONS}
        low, middle, high = sorted(ranges.values())
        assert max(low) < min(middle) <= max(middle) < min(high), habit


def test_populations_differ_in_what_they_begin_with_and_in_who_leads() -> None:
    ways = {
        name: {(p.style.heavy_first, p.style.far_first, p.style.role) for p in population(name)} for name in POPULATIONS
    }
    assert not ways["A"] & ways["B"] and not ways["C"] & (ways["A"] | ways["B"])
    assert {role for _, _, role in ways["A"]} == {"leader", "equal"}
    assert {role for _, _, role in ways["B"]} == {"follower", "equal"}
    sticks = {name: {person.style.stick for person in population(name)} for name in POPULATIONS}
    assert sticks == {"A": {0}, "B": {0, 8}, "C": {0, 8}}


def test_a_stranger_is_answered_with_who_there_is() -> None:
    with pytest.raises(DataError, match="A01 to A20"):
        scripted_person("D01")
    with pytest.raises(DataError, match="known: A, B, C"):
        population("D")


def test_people_play_in_their_own_way_and_always_the_same() -> None:
    the_map = load_map("DistancePriority")

    def played(name: str) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        agents = (load_agent(scripted_person(name).agent_id), load_agent("idle"))
        return np.array([step.actions[0] for step in rollout(the_map, agents, 1, 25)])

    assert np.array_equal(played("A01"), played("A01"))
    assert not np.array_equal(played("A01"), played("B01"))
    assert np.abs(played("B01")[:, 0]).max() <= scripted_person("B01").style.speed < 0.9


def test_a_person_sees_the_partner_late() -> None:
    person = HumanModel("C01")
    the_map = load_map("DistancePriority")
    seen: list[float] = []

    def stand_still(observation: Observation) -> ActionChunk:
        seen.append(float(observation.state.robot_poses[1, 0]))
        return np.array([[0.0, 1.0, 0.0, 0.0]])

    person._plan.act = stand_still  # type: ignore[method-assign]
    places = []
    for step in rollout(the_map, (person, load_agent("tests.agents.support:Forward")), 1, 8):
        places.append(step.before.robot_poses[1, 0])
    delay = scripted_person("C01").style.delay
    assert delay == 2 and seen[delay:] == places[:-delay]


def test_a_habit_of_a_person_can_be_changed() -> None:
    person = load_agent("person:name=B03,stick=8,role=follower")
    assert isinstance(person, HumanModel)
    assert person.style == replace(scripted_person("B03").style, stick=8, role="follower")
    with pytest.raises(AgentError, match=r"no habit 'strength'; known: heavy_first, .*, stick"):
        load_agent("person:name=B03,strength=3")
    with pytest.raises(AgentError, match="stick must be one of 0, 8, not 4"):
        load_agent("person:name=B03,stick=4")


def test_a_person_on_keys_presses_eight_directions_and_gets_everything_home() -> None:
    the_map = load_map("SingleRotation")
    pair = (load_agent("person:name=B01,stick=8"), load_agent("person:name=C02,stick=8"))
    steps = list(rollout(the_map, pair, 0, 400))
    actions = np.array([step.actions for step in steps])
    assert delivered_items(the_map, steps[-1].after.item_poses).all()
    assert set(np.abs(actions[..., 0]).ravel()) == {0.0, 1.0}
    eighths = actions[..., 1] / (np.pi / 4)
    assert np.allclose(eighths, np.rint(eighths)) and len(set(np.rint(eighths[:, 0]))) > 4


def test_taps_add_up_to_a_slow_pace_and_to_a_direction_between_two_keys() -> None:
    the_map = load_map("Simple")
    world, keys = World(the_map), KeyboardModel(the_map, 0)
    places = []
    for _ in range(25):
        places.append(world.state().robot_poses[0, :2])
        world.step(np.array([[*keys.press(world.state(), 0.4, 0.3), 0.0], [0.0, 0.0, 0.0]]))
    x, y = (places[-1] - places[4]) / 20 / 0.06  # strides per tick
    assert (np.hypot(x, y), np.arctan2(-x, y)) == pytest.approx((0.4, 0.3), abs=0.1)


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
    assert scripted_person("A01").style.habits == manifest()["populations"]["A"][0]["style"]  # type: ignore[index]
    assert main(command) == 0  # what is there is not made again
    assert json.loads(capsys.readouterr().out)["episodes"] == 0


def test_demonstrations_of_challenge_2_are_of_four_variants_of_each_map(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["demos", "generate", "--challenge", "2", "--map", "SequentialRotations", "--people", "2"]
    command += ["--episodes", "1", "--ticks", "3", "--workers", "1", "--out", str(tmp_path), "--json"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["episodes"] == 4
    files = sorted(tmp_path.glob("*.mcap"))
    assert [read_episode(file).header.map.variant for file in files] == [f"challenge2-train-{n}" for n in range(4)]
    assert main(command) == 0  # what is there is not made again
    assert json.loads(capsys.readouterr().out)["episodes"] == 0


def test_labels_of_challenge_2_are_of_four_variants_of_each_map(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["demos", "label", "--challenge", "2", "--map", "SingleRotation", "--learner", "idle", "--expert", "idle"]
    command += ["--episodes", "1", "--ticks", "3", "--workers", "1", "--out", str(tmp_path), "--json"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["episodes"] == 4
    variants = sorted(load_correction(file).trajectory.map.variant for file in tmp_path.iterdir())
    assert variants == [f"challenge2-train-{n}" for n in range(4)]


@pytest.mark.parametrize("action", ["generate", "label"])
@pytest.mark.parametrize("option", ["--episodes", "--ticks", "--workers"])
def test_demonstrations_that_cannot_be_made_are_refused_in_a_sentence(
    action: str, option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["demos", action, option, "0", "--out", str(tmp_path / "none")]) == 2
    assert "--episodes, --ticks and --workers must be at least 1" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
