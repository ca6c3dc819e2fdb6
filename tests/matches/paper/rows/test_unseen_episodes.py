"""In which episodes the parts of BASS are measured: of several pairs, and of nobody whom the agent learned from."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.agents.catalogue import load_agent
from movingout.maps import load_map
from movingout.maps.randomize import randomize
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.presentation.layout import laid_out
from movingout.matches.paper.registry import ENTRIES
from movingout.matches.paper.rows import measurements
from movingout.matches.paper.rows.measurements import accuracy
from movingout.matches.paper.rows.unseen_episodes import EPISODES, of_others, pairs_in_turn, unseen_episodes
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.groups import GroupedRecording, grouped, write_groups
from movingout.world.estimates import Estimate
from tests.agents.learning import recorded

MAPS = [f"map {number}" for number in range(12)]
PAIRS = [("A01", "A02"), ("A05", "A06"), ("B01", "B02"), ("B03", "B04")]


def _row(name: str, pair: tuple[str, str], episode: int) -> GroupedRecording:
    people = pair if episode == 0 else pair[::-1]  # they change seats
    path = Path(f"{name}-{''.join(pair)}-{episode}")
    return GroupedRecording(path, 1, path.name, name, "", people, 0.5)


ROWS = [_row(name, pair, episode) for name in MAPS for pair in PAIRS for episode in (0, 1)]


def test_episodes_are_of_pairs_in_turn_who_change_seats() -> None:
    chosen = [row for row in ROWS if row.path in set(pairs_in_turn(ROWS))]
    assert Counter(row.map for row in chosen) == dict.fromkeys(MAPS, EPISODES)
    pairs = Counter(tuple(sorted(row.people)) for row in chosen)
    assert pairs == dict.fromkeys(PAIRS, EPISODES * len(MAPS) // len(PAIRS)), "each as often"
    assert Counter(row.people for row in chosen) == {pair: 3 for one in PAIRS for pair in (one, one[::-1])}
    assert list(pairs_in_turn(reversed(ROWS))) == list(pairs_in_turn(ROWS))


def test_where_a_map_has_few_episodes_all_are_taken_once() -> None:
    one_pair = [_row(name, PAIRS[0], episode) for name in MAPS for episode in (0, 1)]
    assert sorted(pairs_in_turn(one_pair)) == sorted(row.path for row in one_pair)
    alone = [_row(name, PAIRS[0], 0) for name in MAPS]
    assert list(pairs_in_turn(alone)) == sorted(row.path for row in alone)


def test_people_who_were_learned_from_are_left_out_where_others_played_the_map() -> None:
    rows = [*ROWS, _row("theirs", PAIRS[0], 0)]
    kept = of_others(rows, {"A01", "A02"})
    assert {row.people for row in kept if row.map in MAPS} == {one for pair in PAIRS[1:] for one in (pair, pair[::-1])}
    assert [row.path.name for row in kept if row.map == "theirs"] == ["theirs-A01A02-0"]


def test_in_challenge_2_nobody_is_measured_who_recorded_for_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space = Workspace(budget=BUDGETS["smoke"])
    designed = [recorded(tmp_path / "c1", f"{''.join(pair)}", 10, people=pair) for pair in PAIRS]
    variant = randomize(load_map("HandOff"), 0, "official")
    varied = [recorded(tmp_path / "c2", "v", 10, people=("A02", "A01"), the_map=variant)]
    rows = grouped(designed, 2)
    write_groups(space.listing("c1"), rows)
    write_groups(space.listing("c2"), grouped(varied, 1))
    assert [sorted(one.people) for one in unseen_episodes(2, space)] == [["A05", "A06"], ["B01", "B02"]]
    group_b = [sorted(row.people) for row in rows if row.group == 2]
    assert sorted(sorted(one.people) for one in unseen_episodes(1, space)) == sorted(group_b)


def test_what_was_measured_as_if_moments_of_an_episode_were_independent_is_measured_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    space, cell = Workspace(budget=BUDGETS["smoke"]), accuracy("bass", "", 2, "next_state_l2")
    space.keep("accuracy-of-pairs-bass-c2", {"next_state_l2": Estimate(0.2, 0.1, 24)}, cell.measurement.agents_of(0))
    assert cell.found(space) is None
    assert set(cell.measurement.data) == {"c1", "c2"}, "the lists of both have to be there"


def test_moments_of_an_episode_count_together_in_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    values = {"partner_20": [("0", 0.0), ("0", 0.0), ("1", 1.0), ("1", 1.0)], "hands": [("0", 1.0), ("0", 1.0)]}
    monkeypatch.setattr(measurements, "unseen_episodes", lambda challenge, space: [])
    monkeypatch.setattr(measurements, "moment_values", lambda *args, **more: values)
    monkeypatch.setattr(measurements, "load_agent", lambda agent_id: load_agent("bass@any"))
    space = Workspace(budget=replace(BUDGETS["smoke"], trainings=2))
    cell = accuracy("bass", "", 1, "partner_20")
    found = [cell.measurement.perform(space, training) for training in (0, 1)]
    assert found[0] == {"partner_20": Estimate(0.5, 0.5, 4), "hands": Estimate(1.0, None, 2)}
    assert cell.measurement.pool([one["partner_20"] for one in found]) == Estimate(0.5, 0.5, 4)


@pytest.mark.parametrize(("label", "said"), [("tab:next_state_models", True), ("tab:pose_noise_ablation", False)])
def test_tables_of_accuracies_say_what_their_errors_are(
    label: str, said: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    notes = laid_out(ENTRIES[label], Workspace(budget=BUDGETS["smoke"])).notes
    assert any(note.startswith("Of what is measured in moments, ± takes those of an episode") for note in notes) == said
    assert any(note.endswith("it is that of the training with most.") for note in notes) == said
